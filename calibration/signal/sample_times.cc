#include "calibration/signal/sample_times.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {

namespace {

double Next(double t_s) { return std::nextafter(t_s, std::numeric_limits<double>::infinity()); }

}  // namespace

double SampleTimes::OfGyro(double stamp_s, const std::array<bool, 3>& has_axis) {
  bool of_other_axes = true;
  for (std::size_t c = 0; c < 3; ++c)
    of_other_axes = of_other_axes && !(has_axis[c] && gyro_axes_[c]);
  gyro_axes_ = has_axis;
  const double rounded_s = gyro_.Mend(stamp_s);
  const double in_packet_s = gyro_packets_.TimeOf(stamp_s, of_other_axes);
  const bool in_packets = gyro_packets_.in_packets();
  const bool goes_on = in_packets ? stamp_s >= gyro_stamp_s_ : stamp_s > gyro_stamp_s_;
  gyro_stamp_s_ = stamp_s;
  const double t_s = in_packets ? in_packet_s : rounded_s;
  return gyro_s_ = goes_on && t_s <= gyro_s_ ? Next(gyro_s_) : t_s;
}

double SampleTimes::OfReference(std::size_t axis, double stamp_s) {
  constexpr double kGyroIsThere_s = 1.0;
  Axis& read = reference_[std::min<std::size_t>(axis, 2)];
  const double own_s = read.clock.Mend(stamp_s);
  const bool beside_sample = stamp_s == gyro_stamp_s_;
  if (std::fabs(stamp_s - gyro_stamp_s_) < kGyroIsThere_s) Count(beside_sample, &read);
  double t_s = beside_sample && read.share_rows ? gyro_s_ : own_s;
  if (stamp_s > read.stamp_s && t_s <= read.s) t_s = Next(read.s);
  read.stamp_s = stamp_s;
  return read.s = t_s;
}

void SampleTimes::Count(bool beside_sample, Axis* axis) {
  constexpr std::int64_t kMemory = 200;
  constexpr double kShare = 0.9, kShareNoMore = 0.8;
  axis->readings = std::min(axis->readings + 1, kMemory);
  axis->beside_samples +=
      ((beside_sample ? 1.0 : 0.0) - axis->beside_samples) / static_cast<double>(axis->readings);
  axis->share_rows = axis->beside_samples > (axis->share_rows ? kShareNoMore : kShare);
}

}  // namespace gyrobench::calibration
