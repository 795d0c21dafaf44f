#include "calibration/signal/late_rows.h"

#include <algorithm>
#include <limits>

namespace gyrobench::calibration {
namespace {

// Readings over which the rate is taken at the least.
constexpr std::size_t kLeastWindow = 16;
// Of the mean step: a longer one has a reading missing in it. Of packets nearly as long as the
// interval one in a row of readings is 1.6 intervals long.
constexpr double kOneMissing = 1.75;
constexpr double kEnoughWindows = 30.0;
// A share that is none.
constexpr double kHardly = 0.25;

double SecondDifference(double before, double middle, double after) {
  return before - 2.0 * middle + after;
}

}  // namespace

void LateRows::Take(std::size_t axis, double stamp_s, double angle_deg) {
  constexpr double kLongestStep_s = 1.0, kLargestStep_deg = 180.0;
  Axis& read = axes_[std::min<std::size_t>(axis, 2)];
  if (!std::isfinite(angle_deg) || !std::isfinite(stamp_s)) return;
  if (read.count > 0) {
    const double step_s = stamp_s - read.stamp_s[read.At(0)];
    const double step_deg = std::fabs(angle_deg - read.angle_deg[read.At(0)]);
    if (step_deg > 0.0) digit_deg_ = std::min(digit_deg_, step_deg);
    if (!(step_s >= 0.0) || step_s > kLongestStep_s || step_deg > kLargestStep_deg) read.count = 0;
  }
  if (read.count >= kLeastWindow) {
    const double mean_s = (read.stamp_s[read.At(0)] - read.stamp_s[read.At(kLeastWindow - 1)]) /
                          static_cast<double>(kLeastWindow - 1);
    if (!any_step_ && stamp_s - read.stamp_s[read.At(0)] > kOneMissing * mean_s)
      read.since_missing = 0;
  } else {
    read.since_missing = 0;
  }
  ++read.count;
  ++read.since_missing;
  read.stamp_s[read.At(0)] = stamp_s;
  read.angle_deg[read.At(0)] = angle_deg;
  for (std::size_t i = 0; i < kLags.size(); ++i) TakeLag(read, kLags[i], &sums_[i]);
}

// Where the window turns steadily, and no reading is missing in it.
void LateRows::TakeLag(const Axis& axis, std::size_t lag, Sums* sums) {
  // A bend of a steady turn is what its times err by, and no ramp.
  constexpr double kLeastTurn_deg = 0.5, kSteady = 0.1, kMostError_s = 0.02;
  const std::size_t window = std::max(kLeastWindow, 2 * lag), middle = window / 2;
  // Neighbours tell next to nothing new at a long lag.
  if (axis.since_missing <= window || axis.count % std::max<std::size_t>(lag / 4, 1) != 0) return;
  const auto s = [&](std::size_t back) { return axis.stamp_s[axis.At(back)]; };
  const auto deg = [&](std::size_t back) { return axis.angle_deg[axis.At(back)]; };
  const double turn_deg = deg(0) - deg(window), length_s = s(0) - s(window);
  if (!(length_s > 0.0) || !(std::fabs(turn_deg) > kLeastTurn_deg)) return;
  const double bend_deg = SecondDifference(deg(window), deg(middle), deg(0));
  if (std::fabs(bend_deg) > std::fabs(turn_deg) * std::min(kSteady, kMostError_s / length_s) &&
      std::fabs(bend_deg) > kLeastTurn_deg * kSteady)
    return;
  const double uneven_deg =
      turn_deg / length_s * SecondDifference(s(middle + lag), s(middle), s(middle - lag));
  const double angle_deg = SecondDifference(deg(middle + lag), deg(middle), deg(middle - lag));
  sums->count += 1.0;
  sums->square += uneven_deg * uneven_deg;
  sums->product += uneven_deg * angle_deg;
  sums->angles_square += angle_deg * angle_deg;
}

// Second differences of white noise and of lateness are alike correlated from one to the next (-2/3
// and 1/6), by which the variance is 1 + 2 (4/9 + 1/36) of that of independent ones. Readings of a
// coarse encoder may be in step with its digits: rounding alone is 6 digit^2/12, whatever is left.
double LateRows::StdError(const Sums& sums) const {
  constexpr double kOfCorrelation = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);
  if (!(sums.square > 0.0)) return std::numeric_limits<double>::infinity();
  const double left = (sums.angles_square - sums.product * sums.product / sums.square) / sums.count;
  return std::sqrt(kOfCorrelation * std::max(left, 0.5 * digit_deg_ * digit_deg_) / sums.square);
}

bool LateRows::only_stamps() const {
  constexpr double kSure = 0.1, kMatters_deg = 1e-3;
  const Sums& near = sums_[0];
  return near.count >= kEnoughWindows && near.square > near.count * kMatters_deg * kMatters_deg &&
         share_std_error() < kSure && std::fabs(share()) < kHardly && !of_their_stamps();
}

bool LateRows::of_their_stamps() const {
  constexpr double kSigmas = 5.0;
  return std::ranges::any_of(sums_, [&](const Sums& sums) {
    return sums.count >= kEnoughWindows &&
           sums.product / sums.square - kSigmas * StdError(sums) > kHardly;
  });
}

double LateRows::Misfit_deg2(std::size_t lag) const {
  const Sums& sums = sums_[lag];
  if (sums.count < kEnoughWindows) return kMissing;
  return (sums.angles_square - 2.0 * sums.product + sums.square) / sums.count;
}

void LateRows::Join(const LateRows& other) {
  digit_deg_ = std::max(digit_deg_ < 360.0 ? digit_deg_ : 0.0, other.digit_deg_);
  for (std::size_t i = 0; i < kLags.size(); ++i) {
    sums_[i].count += other.sums_[i].count;
    sums_[i].square += other.sums_[i].square;
    sums_[i].product += other.sums_[i].product;
    sums_[i].angles_square += other.sums_[i].angles_square;
  }
}

bool EvenRows::any() const {
  const auto known = [](const KnownClock& clock) { return std::isfinite(clock.interval_s); };
  return gyro_is_polled || known(gyro) || known(rounded_gyro) ||
         std::ranges::any_of(reference, known) || std::ranges::any_of(rounded_reference, known);
}

std::vector<EvenRows> RowsThatComeEvenly(std::span<const RowTiming> timings) {
  LateRows shared, own;
  for (const RowTiming& each : timings) {
    if (!each.shared.of_their_stamps()) shared.Join(each.shared);
    if (!each.own.of_their_stamps()) own.Join(each.own);
  }
  std::vector<EvenRows> even(timings.size());
  for (std::size_t i = 0; i < timings.size(); ++i) {
    const RowTiming& each = timings[i];
    even[i].rounded_gyro = each.clocks.rounded_gyro;
    even[i].rounded_reference = each.clocks.rounded_reference;
    // Rows that are lost count for the stamps there, and not where nothing is missing.
    even[i].gyro_is_polled =
        each.put_on_line > 0 && each.by_stamps.of_their_stamps() && !each.shared.only_stamps();
    if (even[i].gyro_is_polled) continue;
    if (each.in_packets || (shared.only_stamps() && !each.shared.of_their_stamps()))
      even[i].gyro = each.clocks.gyro;
    if (own.only_stamps() && !each.own.of_their_stamps()) even[i].reference = each.clocks.reference;
  }
  return even;
}

bool IsAsEvenAs(const RowTiming& mended, const RowTiming& before) {
  constexpr double kMostLost = 2e-3;  // of the rows
  if (mended.lost < 0 ||
      static_cast<double>(mended.lost) > kMostLost * static_cast<double>(mended.put_on_line))
    return false;
  // Of few rows that are lost the line is off for a while, which is seen at long lags.
  const auto all_lags_deg2 = [](const LateRows& rows) {
    double sum = 0.0;
    for (std::size_t lag = 0; lag < LateRows::kLags.size(); ++lag) {
      const double misfit_deg2 = rows.Misfit_deg2(lag);
      if (std::isfinite(misfit_deg2)) sum += misfit_deg2;
    }
    return sum;
  };
  constexpr double kMostMore = 1.1;  // by chance
  return all_lags_deg2(mended.shared) <= kMostMore * all_lags_deg2(before.shared) &&
         all_lags_deg2(mended.own) <= kMostMore * all_lags_deg2(before.own);
}

}  // namespace gyrobench::calibration
