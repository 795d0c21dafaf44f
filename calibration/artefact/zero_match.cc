#include "calibration/artefact/zero_match.h"

#include <fmt/format.h>

#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr int kSamples = 33;

}  // namespace

ZeroMatch::ZeroMatch(const Calibration& calibration, const MeasurementInfo& info)
    : name_(info.source.empty() ? "measurement" : info.source) {
  if (info.gyro_unit != RateUnit::kLsb || !calibration.gyro_lsb_zero) return;
  calibrated_zero_ = *calibration.gyro_lsb_zero;
  difference_ = calibrated_zero_ - info.gyro_lsb_zero.value_or(0.0);
  if (difference_ == 0.0) return;
  for (const ChannelCalibration& one : calibration.channels) {
    const double bias = one.model.bias_deg_s.empty() ? 0.0 : one.model.bias_deg_s[0];
    axes_.push_back({static_cast<std::size_t>(one.model.axis), one.model.units_per_deg_s, bias});
  }
  if (info.gyro_lsb_zero && calibrated_zero_ != 0.0) {
    off_ = difference_;
  } else {
    decided_ = false;
  }
}

void ZeroMatch::Watch(const Vector3& xi) {
  if (decided_) return;
  bool any = false;
  for (const Axis& axis : axes_) {
    const double value = xi[axis.channel];
    if (!std::isfinite(value)) continue;
    const double bias = axis.units_per_deg_s * axis.bias_deg_s;
    const bool nearer = std::fabs(value - difference_ - bias) < std::fabs(value - bias);
    ++(nearer ? for_difference_ : against_);
    any = true;
  }
  samples_ += any ? 1 : 0;
  if (samples_ >= kSamples) Decide();
}

void ZeroMatch::Decide() {
  if (decided_) return;
  decided_ = true;
  off_ = for_difference_ > against_ ? difference_ : 0.0;
}

std::string ZeroMatch::Remark() const {
  if (off_ < 0.0 && calibrated_zero_ == 0.0) {
    return fmt::format(
        "the calibration has the count of zero in its bias: {:g} is put back into {}", -off_,
        name_);
  }
  if (off_ != 0.0) {
    return fmt::format("the calibration is of counts less {:g}: {:g} is taken off those of {}",
                       calibrated_zero_, off_, name_);
  }
  if (difference_ <= 0.0) return "";
  return fmt::format(
      "the calibration is of counts less {:g}: those of {} are centred already and taken as they "
      "are",
      calibrated_zero_, name_);
}

}  // namespace gyrobench::calibration
