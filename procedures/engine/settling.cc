#include "procedures/engine/settling.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gyrobench::procedures {
namespace {

constexpr double kNotKnown = std::numeric_limits<double>::quiet_NaN();
// The decay is read from two changes that differ by more than their noise.
constexpr double kLeastDecay = 1.2;

}  // namespace

// end - cold exp(-t/tau) changes by less than drift within the window w that ends at t when
//   cold exp(-t/tau) (exp(w/tau) - 1) < drift,   t = tau ln(cold (exp(w/tau) - 1) / drift)
double ExpectedSoak_s(const SoakCommand& command, double begin_s, double cold_degC,
                      double time_constant_s) {
  const double at_window_end = cold_degC * std::expm1(command.window_s / time_constant_s);
  const double settled_s = time_constant_s * std::log(at_window_end / command.drift_degC) - begin_s;
  return std::min(command.max_s, std::max({command.min_s, command.window_s, settled_s}));
}

Settling::Settling(const SoakCommand& command, double begin_s)
    : command_(command), expected_s_(ExpectedSoak_s(command, begin_s)), change_degC_(kNotKnown) {}

void Settling::Add(double t_s, double temperature_degC) {
  t_s_ = t_s;
  change_degC_ = kNotKnown;
  if (!std::isfinite(temperature_degC)) {
    window_.clear();
    changes_.clear();
    return;
  }
  window_.push_back({t_s, temperature_degC});
  if (t_s - window_.front().t_s < command_.window_s) return;
  while (window_.size() > 2 && t_s - window_[1].t_s >= command_.window_s) window_.pop_front();
  change_degC_ = Change();
  changes_.push_back({t_s, change_degC_});
  while (t_s - changes_.front().t_s > command_.window_s) changes_.pop_front();
}

// The larger of the change along the line by least squares and of the range of the quarters' means.
double Settling::Change() const {
  const double begin_s = window_.front().t_s, length_s = window_.back().t_s - begin_s;
  double t_mean = 0.0, degC_mean = 0.0;
  for (const Reading& reading : window_) {
    t_mean += reading.t_s / static_cast<double>(window_.size());
    degC_mean += reading.degC / static_cast<double>(window_.size());
  }
  double tt = 0.0, t_degC = 0.0;
  std::array<double, 4> sums = {}, counts = {};
  for (const Reading& reading : window_) {
    tt += (reading.t_s - t_mean) * (reading.t_s - t_mean);
    t_degC += (reading.t_s - t_mean) * (reading.degC - degC_mean);
    const auto quarter = static_cast<std::size_t>(4.0 * (reading.t_s - begin_s) / length_s);
    sums.at(std::min<std::size_t>(quarter, 3)) += reading.degC;
    counts.at(std::min<std::size_t>(quarter, 3)) += 1.0;
  }
  double low = kNotKnown, high = kNotKnown;
  for (std::size_t i = 0; i < sums.size(); ++i) {
    if (counts[i] == 0.0) continue;
    low = std::fmin(low, sums[i] / counts[i]);
    high = std::fmax(high, sums[i] / counts[i]);
  }
  return std::max(std::abs(t_degC / tt) * length_s, high - low);
}

bool Settling::settled() const {
  return change_degC_ < command_.drift_degC && t_s_ >= command_.min_s;
}

double Settling::remaining_s() const {
  const double most_s = std::max(0.0, command_.max_s - t_s_);
  const double least_s = std::max(0.0, command_.min_s - t_s_);
  if (std::isnan(change_degC_)) return std::clamp(expected_s_ - t_s_, least_s, most_s);
  const Reading& before = changes_.front();
  double time_constant_s = kExpectedTimeConstant_s;
  if (before.degC > kLeastDecay * change_degC_)
    time_constant_s = (t_s_ - before.t_s) / std::log(before.degC / change_degC_);
  const double left_s = time_constant_s * std::log(change_degC_ / command_.drift_degC);
  return std::clamp(left_s, std::min(least_s, most_s), most_s);
}

}  // namespace gyrobench::procedures
