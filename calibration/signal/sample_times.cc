#include "calibration/signal/sample_times.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {

namespace {

double Next(double t_s) { return std::nextafter(t_s, std::numeric_limits<double>::infinity()); }

}  // namespace

SampleTimes::SampleTimes(const EvenRows& even)
    : gyro_(even.rounded_gyro),
      covariates_(even.rounded_gyro),
      gyro_packets_(even.gyro),
      gyro_is_polled_(even.gyro_is_polled),
      drift_{even.reference_drift_ppm, 0.0} {
  for (std::size_t a = 0; a < 3; ++a) {
    reference_[a].clock = EvenStamps(even.rounded_reference[a]);
    reference_[a].packets = PacketStamps(even.reference[a]);
  }
}

void SampleTimes::BeginAnew(const EvenRows& even) {
  SampleTimes anew(even);
  anew.shared_rows_ = shared_rows_;
  anew.own_rows_ = own_rows_;
  anew.by_stamps_ = by_stamps_;
  anew.drift_ = drift_;
  anew.began_ = began_;
  *this = anew;
}

void SampleTimes::BeginWith(double stamp_s) {
  if (!began_) drift_.begin_s = stamp_s;
  began_ = true;
}

double SampleTimes::OfGyro(double stamp_s, const std::array<bool, 3>& has_axis) {
  BeginWith(stamp_s);
  bool of_other_axes = true;
  for (std::size_t c = 0; c < 3; ++c)
    of_other_axes = of_other_axes && !(has_axis[c] && gyro_axes_[c]);
  gyro_axes_ = has_axis;
  const double rounded_s = gyro_.Mend(stamp_s);
  const double in_packet_s = gyro_packets_.TimeOf(stamp_s, of_other_axes);
  wrong_since_s_ = gyro_is_polled_ ? kMissing : gyro_packets_.wrong_since_s();
  ++samples_;
  const bool on_line = !gyro_is_polled_ && gyro_packets_.mends();
  const bool goes_on = on_line ? stamp_s >= gyro_stamp_s_ : stamp_s > gyro_stamp_s_;
  gyro_stamp_s_ = stamp_s;
  const double t_s = on_line ? in_packet_s : rounded_s;
  return gyro_s_ = goes_on && t_s <= gyro_s_ ? Next(gyro_s_) : t_s;
}

double SampleTimes::OfReference(std::size_t axis, double stamp_s, double angle_deg) {
  constexpr double kGyroIsThere_s = 1.0;
  BeginWith(stamp_s);
  Axis& read = reference_[std::min<std::size_t>(axis, 2)];
  const double rounded_s = read.clock.Mend(stamp_s);
  const double on_line_s = read.packets.TimeOf(stamp_s);
  const double own_s = read.packets.mends() ? on_line_s : rounded_s;
  const bool beside_sample = stamp_s == gyro_stamp_s_;
  if (std::fabs(stamp_s - gyro_stamp_s_) < kGyroIsThere_s) Count(beside_sample, &read);
  const bool shared = beside_sample && read.share_rows;
  double t_s = shared ? gyro_s_ : own_s;
  const double wrong_since_s = shared ? kMissing : read.packets.wrong_since_s();
  wrong_since_s_ = wrong_since_s + drift_.OfStamp_s(wrong_since_s);
  if (stamp_s > read.stamp_s && t_s <= read.s) t_s = Next(read.s);
  read.stamp_s = stamp_s;
  (shared ? shared_rows_ : own_rows_).Take(axis, t_s, angle_deg);
  if (shared) by_stamps_.Take(axis, stamp_s, angle_deg);
  read.s = t_s;
  return t_s + drift_.OfStamp_s(t_s);
}

RowTiming SampleTimes::Rows() const {
  RowTiming rows{.shared = shared_rows_, .own = own_rows_, .by_stamps = by_stamps_, .clocks = {}};
  rows.clocks.gyro = gyro_packets_.Clock();
  rows.clocks.rounded_gyro = gyro_.Clock();
  rows.in_packets = 2 * gyro_packets_.on_line() > samples_;
  rows.put_on_line = gyro_is_polled_ ? 0 : gyro_packets_.on_line();
  rows.lost = gyro_is_polled_ ? 0 : gyro_packets_.lost();
  for (std::size_t a = 0; a < 3; ++a) {
    if (reference_[a].share_rows) continue;
    const PacketStamps& packets = reference_[a].packets;
    rows.clocks.reference[a] = packets.Clock();
    rows.clocks.rounded_reference[a] = reference_[a].clock.Clock();
    rows.put_on_line += packets.on_line();
    rows.lost += packets.lost();
  }
  return rows;
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
