#include "calibration/signal/late_rows.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {
namespace {

double SecondDifference(double before, double middle, double after) {
  return before - 2.0 * middle + after;
}

}  // namespace

void LateRows::Take(std::size_t axis, double stamp_s, double angle_deg) {
  constexpr double kLongestStep_s = 1.0, kLargestStep_deg = 180.0;
  Axis& read = axes_[std::min<std::size_t>(axis, 2)];
  if (!std::isfinite(angle_deg) || !std::isfinite(stamp_s)) return;
  const double step_s = stamp_s - read.stamp_s.back();
  if (!(step_s >= 0.0) || step_s > kLongestStep_s ||
      std::fabs(angle_deg - read.angle_deg.back()) > kLargestStep_deg)
    read.count = 0;
  std::shift_left(read.stamp_s.begin(), read.stamp_s.end(), 1);
  std::shift_left(read.angle_deg.begin(), read.angle_deg.end(), 1);
  read.stamp_s.back() = stamp_s;
  read.angle_deg.back() = angle_deg;
  if (++read.count >= kWindow) TakeMiddleOf(read);
}

// Where the window turns steadily, and no reading is missing about its middle.
void LateRows::TakeMiddleOf(const Axis& axis) {
  constexpr double kLeastTurn_deg = 0.5, kSteady = 0.1, kOneMissing = 1.65;
  const auto& s = axis.stamp_s;
  const auto& deg = axis.angle_deg;
  const double turn_deg = deg.back() - deg.front(), length_s = s.back() - s.front();
  if (!(length_s > 0.0) || !(std::fabs(turn_deg) > kLeastTurn_deg)) return;
  const double bend_deg = SecondDifference(deg.front(), deg[kMiddle], deg.back());
  const double before_s = s[kMiddle] - s[kMiddle - 1], after_s = s[kMiddle + 1] - s[kMiddle];
  const double longest_s = kOneMissing * length_s / static_cast<double>(kWindow - 1);
  if (std::fabs(bend_deg) > kSteady * std::fabs(turn_deg) ||
      std::max(before_s, after_s) > longest_s)
    return;
  const double uneven_deg = turn_deg / length_s * (after_s - before_s);
  const double angle_deg = SecondDifference(deg[kMiddle - 1], deg[kMiddle], deg[kMiddle + 1]);
  count_ += 1.0;
  square_ += uneven_deg * uneven_deg;
  product_ += uneven_deg * angle_deg;
  angles_square_ += angle_deg * angle_deg;
}

// Second differences of white noise and of lateness are alike correlated from one to the next (-2/3
// and 1/6), by which the variance is 1 + 2 (4/9 + 1/36) of that of independent ones.
double LateRows::share_std_error() const {
  constexpr double kOfCorrelation = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);
  if (!(square_ > 0.0)) return std::numeric_limits<double>::infinity();
  const double left = std::max(angles_square_ - product_ * product_ / square_, 0.0) / count_;
  return std::sqrt(kOfCorrelation * left / square_);
}

bool LateRows::only_stamps() const {
  constexpr double kHardly = 0.25, kSure = 0.05, kLeastCount = 100.0, kMatters_deg = 1e-3;
  return count_ >= kLeastCount && square_ > count_ * kMatters_deg * kMatters_deg &&
         share_std_error() < kSure && std::fabs(share()) < kHardly;
}

void LateRows::Join(const LateRows& other) {
  count_ += other.count_;
  square_ += other.square_;
  product_ += other.product_;
  angles_square_ += other.angles_square_;
}

std::vector<EvenRows> RowsThatComeEvenly(std::span<const RowTiming> timings) {
  LateRows shared, own;
  for (const RowTiming& each : timings) {
    shared.Join(each.shared);
    own.Join(each.own);
  }
  std::vector<EvenRows> even(timings.size());
  for (std::size_t i = 0; i < timings.size(); ++i) {
    even[i].told_by = timings[i].interval.told_by;
    const bool in_packets = timings[i].interval.told_by > 0.0;
    if (in_packets || shared.only_stamps() || own.only_stamps())
      even[i].gyro_s = timings[i].interval.gyro_s;
    if (own.only_stamps()) even[i].reference_s = timings[i].interval.reference_s;
  }
  return even;
}

}  // namespace gyrobench::calibration
