#include "calibration/signal/even_stamps.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr std::array<double, 5> kPerDigit = {1.0, 1e1, 1e2, 1e3, 1e4};
constexpr double kNoDigit = 1e-4;  // of a digit: rounding of the number
// A line through so many is better than the stamps; one over a longer time would lag behind a clock
// that warms up as fast as one of resistor and capacitor.
constexpr std::int64_t kLeastCount = 32;
constexpr double kShortMemory = 400.0, kShortMemory_s = 20.0;
// Of milliseconds, and for coarser digits longer: where the interval is nearly a whole number of
// digits, as of a quartz that is off by 20 ppm, the stamps step by one more once a minute, and a
// shorter line goes along with them. A clock that drifts is off by less of a coarser digit.
constexpr double kLongMemory_s = 50.0, kLongMemoryDigit_s = 1e-3, kLongMemoryPower = 0.6;
// Beats in the memory of the short line, of which fewer are not averaged out.
constexpr double kSlowBeats = 3.0;
// Of the last digit: where the beat is slower than the memory, the line goes along with the stamps
// until they step by a whole one; of a line through a few, which is less sure.
constexpr double kOff = 1.05, kOffOfFew = 2.0;
// Of its square: rounding alone leaves 1/12 about the line. The long line is believed from less on.
constexpr double kOnlyRounded = 0.11, kSurelyRounded = 0.09;
constexpr double kSame_s = 1e-9;
constexpr double kLongestPause_s = 2.0;
constexpr double kFewDigits = 4.5;

}  // namespace

double EvenStamps::Mend(double stamp_s) {
  if (digits_ > kMostDigits || !std::isfinite(stamp_s)) return stamp_s;
  if (count_ > 0 && stamp_s == last_s_) return last_mended_s_;
  FindDigits(stamp_s);
  if (const double step_s = stamp_s - last_s_; count_ > 0 && step_s > kFewDigits * digit_s_) {
    ++gaps_.gaps;
    gaps_.gaps_s += step_s;
  }
  if (stamp_s == known_.first_stamp_s) {
    Begin(stamp_s);
    held_ = true;
  }
  if (double line_s = 0.0; held_ && IsOnKnownLine(stamp_s, &line_s)) {
    last_s_ = stamp_s;
    return last_mended_s_ = std::max(line_s, JustAfter(last_mended_s_));
  }
  const double step_s = stamp_s - last_s_;
  if (held_) Begin(last_s_);
  if (count_ == 0 || digits_ > kMostDigits || !Follows(stamp_s, step_s)) {
    const bool goes_on = count_ > 0 && step_s > 0.0;
    const double begin_s = goes_on ? std::max(stamp_s, JustAfter(last_mended_s_)) : stamp_s;
    Begin(stamp_s);
    return last_mended_s_ = begin_s;
  }
  Add(stamp_s);
  const double digit_s2 = digit_s_ * digit_s_;
  long_is_right_ = long_.left_s2() < (long_is_right_ ? kOnlyRounded : kSurelyRounded) * digit_s2;
  const double towards = long_is_right_ && BeatsSlowly() ? 1.0 : -1.0;
  share_of_long_ = std::clamp(share_of_long_ + towards / ShortMemory(), 0.0, 1.0);
  const bool on_long = share_of_long_ > 0.0 && long_is_right_;
  const bool rounded = (on_long || short_.left_s2() < kOnlyRounded * digit_s2) && !MayBeJitter();
  const bool on_line = count_ >= kLeastCount && !exact_ && rounded;
  const double line_s = first_s_ + LineAt(place_);
  if (count_ == kLeastCount && !exact_ && !rounded) Begin(stamp_s);
  last_s_ = stamp_s;
  last_mended_s_ = std::max(on_line ? line_s : stamp_s, JustAfter(last_mended_s_));
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
  place_ = 0.0;
  long_is_right_ = false;
  share_of_long_ = 0.0;
  short_ = long_ = {};
  whole_.Begin(stamp_s);
  held_ = false;
}

// Rounded, it is half a digit from its place on the line at most.
bool EvenStamps::IsOnKnownLine(double stamp_s, double* line_s) const {
  constexpr double kMostOff = 0.75;  // digits
  const double first_s = known_.first_stamp_s + known_.line_less_first_s;
  const double place = std::round((stamp_s - first_s) / known_.interval_s);
  *line_s = first_s + place * known_.interval_s;
  return std::fabs(stamp_s - *line_s) < kMostOff * digit_s_;
}

StampSteps EvenStamps::Steps() const {
  return {digits_ > kMostDigits ? 0.0 : digit_s_, gaps_.gaps, gaps_.gaps_s};
}

KnownClock EvenStamps::Clock() const {
  constexpr double kCoarse = 0.1;  // of the interval
  if (exact_ || digits_ > kMostDigits || digit_s_ < kCoarse * Slope() || MayBeJitter()) return {};
  return whole_.Clock(std::sqrt(kSurelyRounded) * digit_s_);
}

// Whole digits all lie on a line of one digit a place, and on one of which many places are empty:
// a clock that jitters by a part of a short interval seems to run by such a line.
bool EvenStamps::MayBeJitter() const {
  constexpr double kShort = 5.0;       // digits an interval
  constexpr double kMostPlaces = 1.5;  // for each stamp
  const double digits = Slope() / digit_s_;
  return digits < kLeastDigitsOfInterval ||
         (digits < kShort && place_ > kMostPlaces * static_cast<double>(count_ - 1));
}

// Moves on to the stamp's place, if it has one. Of a few stamps, which make a rough line, it is the
// next one where its step is the shortest or one digit more, as rounding makes them, and where all
// steps were the same, where it is one digit more or less; where a lost sample makes such a step
// too, the line shows it.
bool EvenStamps::Follows(double stamp_s, double step_s) {
  if (!(step_s > 0.0) || step_s > kLongestPause_s) return false;
  if (count_ == 1) {
    first_step_s_ = shortest_step_s_ = short_.step_s = long_.step_s = step_s;
    place_ = 1.0;
    return true;
  }
  const double shortest_s = std::min(shortest_step_s_, step_s);
  const double slope_s = Slope(), last_line_s = first_s_ + LineAt(place_);
  const bool of_few = count_ < kLeastCount && step_s < shortest_s + kOff * digit_s_;
  const bool of_exact = exact_ && first_step_s_ > kLeastDigitsOfInterval * digit_s_ &&
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

double EvenStamps::LineAt(double place) const {
  if (short_.square <= 0.0) return place * first_step_s_;
  return (1.0 - share_of_long_) * short_.At(place) + share_of_long_ * long_.At(place);
}

double EvenStamps::ShortMemory() const {
  return std::clamp(kShortMemory_s / first_step_s_, static_cast<double>(kLeastCount), kShortMemory);
}

// Of the interval with the digit, and of two intervals with it, whose beat is half as large.
bool EvenStamps::BeatsSlowly() const {
  const double digits = long_.slope_s() / digit_s_;
  const auto beats = [&](double intervals) {
    return std::fabs(intervals * digits - std::round(intervals * digits)) * ShortMemory();
  };
  return beats(1.0) < kSlowBeats || beats(2.0) < kSlowBeats;
}

void EvenStamps::Add(double stamp_s) {
  const double coarser = std::max(digit_s_ / kLongMemoryDigit_s, 1.0);
  const double long_memory = kLongMemory_s * std::pow(coarser, kLongMemoryPower) / first_step_s_;
  ++count_;
  whole_.Add(place_, stamp_s - first_s_);
  short_.Add(place_, stamp_s - first_s_, ShortMemory());
  long_.Add(place_, stamp_s - first_s_, std::max(long_memory, ShortMemory()));
  if (count_ < kLeastCount || !std::has_single_bit(static_cast<std::uint64_t>(count_))) return;
  short_.MakeStepsItsOwn();
  long_.MakeStepsItsOwn();
}

}  // namespace gyrobench::calibration
