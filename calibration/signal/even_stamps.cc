#include "calibration/signal/even_stamps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {
namespace {

// Stamps of more digits need no mending: 10 us at 100 deg/s are a thousandth of a degree.
constexpr int kMostDigits = 4;
constexpr std::array<double, kMostDigits + 1> kPerDigit = {1.0, 1e1, 1e2, 1e3, 1e4};
constexpr double kNoDigit = 1e-4;  // of a digit: rounding of the number
// A line through so many is better than the stamps; one through many more, or over a longer time,
// would lag behind a clock that warms up.
constexpr std::int64_t kLeastCount = 32;
constexpr double kMemory = 400.0, kMemory_s = 20.0;
// These are for milliseconds. Of coarser digits a clock that drifts is off by less, and where the
// interval is nearly a whole number of them the stamps step by one more every minute only.
constexpr double kMemoryDigit_s = 1e-3;
// Of the last digit: where the beat is slower than the memory, the line goes along with the stamps
// until they step by a whole one; of a line through a few, which is less sure.
constexpr double kOff = 1.05, kOffOfFew = 2.0;
// Of its square: rounding alone leaves 1/12 about the line.
constexpr double kOnlyRounded = 0.11;
// Of an interval of fewer digits a step does not say whether a sample was lost.
constexpr double kLeastDigits = 1.25;
constexpr double kSame_s = 1e-9;
constexpr double kLongestPause_s = 2.0;

}  // namespace

double EvenStamps::Mend(double stamp_s) {
  if (digits_ > kMostDigits || !std::isfinite(stamp_s)) return stamp_s;
  if (count_ > 0 && stamp_s == last_s_) return last_mended_s_;
  FindDigits(stamp_s);
  const double step_s = stamp_s - last_s_;
  if (count_ == 0 || digits_ > kMostDigits || !Follows(stamp_s, step_s)) {
    const bool goes_on = count_ > 0 && step_s > 0.0;
    const double begin_s = goes_on ? std::max(stamp_s, After(last_mended_s_)) : stamp_s;
    Begin(stamp_s);
    return last_mended_s_ = begin_s;
  }
  Add(stamp_s);
  const double line_s = first_s_ + mean_s_ + Slope() * (place_ - mean_place_);
  // What the line leaves of the variance of the stamps.
  const double left = (stamps_square_ - product_ * Slope()) / (weight_ * digit_s_ * digit_s_);
  const bool rounded = left < kOnlyRounded && !MayBeJitter();
  const bool on_line = count_ >= kLeastCount && !exact_ && rounded;
  if (count_ == kLeastCount && !exact_ && !rounded) Begin(stamp_s);
  last_s_ = stamp_s;
  last_mended_s_ = std::max(on_line ? line_s : stamp_s, After(last_mended_s_));
  return last_mended_s_;
}

void EvenStamps::FindDigits(double stamp_s) {
  for (; digits_ <= kMostDigits; ++digits_) {
    const double in_digits = stamp_s * kPerDigit[static_cast<std::size_t>(digits_)];
    if (std::fabs(in_digits - std::round(in_digits)) < kNoDigit) break;
  }
  if (digits_ <= kMostDigits) digit_s_ = 1.0 / kPerDigit[static_cast<std::size_t>(digits_)];
}

void EvenStamps::Begin(double stamp_s) {
  first_s_ = last_s_ = stamp_s;
  count_ = 1;
  exact_ = true;
  weight_ = 1.0;
  place_ = mean_place_ = mean_s_ = square_ = product_ = stamps_square_ = 0.0;
}

// Whole digits all lie on a line of one digit a place, and on one of which many places are empty:
// a clock that jitters by a part of a short interval seems to run by such a line.
bool EvenStamps::MayBeJitter() const {
  constexpr double kShort = 5.0;       // digits an interval
  constexpr double kMostPlaces = 1.5;  // for each stamp
  const double digits = Slope() / digit_s_;
  return digits < kLeastDigits ||
         (digits < kShort && place_ > kMostPlaces * static_cast<double>(count_ - 1));
}

double EvenStamps::After(double t_s) {
  return std::max(t_s + kSame_s, std::nextafter(t_s, std::numeric_limits<double>::infinity()));
}

// Moves on to the stamp's place, if it has one. Of a few stamps, which make a rough line, it is the
// next one where its step is the shortest or one digit more, as rounding makes them, and where all
// steps were the same, where it is one digit more or less; where a lost sample makes such a step
// too, the line shows it.
bool EvenStamps::Follows(double stamp_s, double step_s) {
  if (!(step_s > 0.0) || step_s > kLongestPause_s) return false;
  if (count_ == 1) {
    first_step_s_ = shortest_step_s_ = step_s;
    place_ = 1.0;
    return true;
  }
  const double shortest_s = std::min(shortest_step_s_, step_s);
  const double slope_s = Slope(),
               last_line_s = first_s_ + mean_s_ + slope_s * (place_ - mean_place_);
  const bool of_few = count_ < kLeastCount && step_s < shortest_s + kOff * digit_s_;
  const bool of_exact = exact_ && first_step_s_ > kLeastDigits * digit_s_ &&
                        std::fabs(step_s - first_step_s_) < kOff * digit_s_;
  const double places = of_few || of_exact ? 1.0 : std::round((stamp_s - last_line_s) / slope_s);
  if (!(places >= 1.0)) return false;
  const double line_s = last_line_s + slope_s * places;
  const double most_s = (count_ < kLeastCount ? kOffOfFew : kOff) * digit_s_;
  if (!(std::fabs(stamp_s - line_s) < most_s)) return false;
  place_ += places;
  shortest_step_s_ = shortest_s;
  exact_ = exact_ && std::fabs(step_s - places * first_step_s_) < kSame_s;
  return true;
}

void EvenStamps::Add(double stamp_s) {
  const double coarser = std::max(digit_s_ / kMemoryDigit_s, 1.0);
  const double memory = std::clamp(kMemory_s * coarser / first_step_s_,
                                   static_cast<double>(kLeastCount), kMemory * coarser * coarser);
  if (weight_ >= memory) {
    const double keep = memory / (memory + 1.0);
    weight_ *= keep;
    square_ *= keep;
    product_ *= keep;
    stamps_square_ *= keep;
  }
  ++count_;
  weight_ += 1.0;
  const double from_place = place_ - mean_place_, from_s = stamp_s - first_s_ - mean_s_;
  mean_place_ += from_place / weight_;
  mean_s_ += from_s / weight_;
  square_ += from_place * (place_ - mean_place_);
  product_ += from_place * (stamp_s - first_s_ - mean_s_);
  stamps_square_ += from_s * (stamp_s - first_s_ - mean_s_);
}

}  // namespace gyrobench::calibration
