#include "base/tick_fit.h"

#include <cmath>

namespace gyrobench {

TickFit::TickFit(double memory_s) : memory_s_(memory_s) {}

void TickFit::Add(const TickPair& pair) {
  if (count_ > 0 && pair.tick_s < last_tick_) BeginAnew();
  if (!(weight_ > 0.0)) {
    ++lines_;
    tick0_ = pair.tick_s;
    host0_ = pair.host_s;
    last_tick_ = pair.tick_s;
  }
  const double keep = std::exp(-(pair.tick_s - last_tick_) / memory_s_);
  last_tick_ = pair.tick_s;
  const double tick = pair.tick_s - tick0_;
  // Offsets instead of host times: the two clocks agree to a fraction of a percent, and so digits
  // are kept.
  const double offset = (pair.host_s - host0_) - tick;
  weight_ *= keep;
  all_weight_ *= keep;
  s_tt_ *= keep;
  s_to_ *= keep;
  s_oo_ *= keep;
  const double weight = weight_ + 1.0;
  const double d_tick = tick - mean_tick_;
  const double d_offset = offset - mean_offset_;
  const double shrink = weight_ / weight;
  s_tt_ += shrink * d_tick * d_tick;
  s_to_ += shrink * d_tick * d_offset;
  s_oo_ += shrink * d_offset * d_offset;
  mean_tick_ += d_tick / weight;
  mean_offset_ += d_offset / weight;
  weight_ = weight;
  all_weight_ += 1.0;
  ++count_;
}

double TickFit::HostTime(double tick_s) const {
  if (count_ == 0) return kMissing;
  const double slope = s_tt_ > 0 ? s_to_ / s_tt_ : 0.0;
  const double tick = tick_s - tick0_;
  return host0_ + tick + mean_offset_ + slope * (tick - mean_tick_);
}

double TickFit::ratio() const { return s_tt_ > 0 ? 1.0 + s_to_ / s_tt_ : kMissing; }

double TickFit::residual_rms_s() const {
  if (count_ < lines_ + 2 || !(s_tt_ > 0)) return kMissing;
  const double sum = std::fmax(0.0, s_oo_ - s_to_ * s_to_ / s_tt_);
  return std::sqrt(sum / all_weight_);
}

double TickFit::ratio_std_error() const {
  if (count_ < lines_ + 2 || !(s_tt_ > 0) || std::isfinite(memory_s_)) return kMissing;
  const double sum = std::fmax(0.0, s_oo_ - s_to_ * s_to_ / s_tt_);
  return std::sqrt(sum / static_cast<double>(count_ - lines_ - 1) / s_tt_);
}

}  // namespace gyrobench
