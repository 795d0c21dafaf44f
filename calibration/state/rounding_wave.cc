#include "calibration/state/rounding_wave.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/robust.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kEighth_deg = 45.0;

// Mean square of one reading in squares of a step: the median over the places where the axis
// rested, of which one may be a slow turn that passes for a rest, and how many these are. NaN where
// it never rested.
struct Flicker {
  double square = kMissing;
  std::size_t places = 0;
};

// Of one rest; NaN where it has no change.
double FlickerIn(const NodeRange& rest, const std::vector<Node>& nodes, std::size_t axis,
                 double step_deg) {
  double square_deg2 = 0.0;
  const std::vector<double> changes_deg = ChangesAtRest(nodes, rest, axis);
  for (const double change_deg : changes_deg) square_deg2 += 0.5 * change_deg * change_deg;
  return square_deg2 / static_cast<double>(changes_deg.size()) / (step_deg * step_deg);
}

double CountsOfAnEighth(double step_deg) { return std::round(kEighth_deg / step_deg); }

// Where in its step an axis rests: poses that are an eighth of a turn apart are so by a whole
// number of the steps of an encoder of some bits, and count as one place.
double CountOf(double angle_deg, double step_deg) {
  const double within_deg = angle_deg - kEighth_deg * std::floor(angle_deg / kEighth_deg);
  const double counts = CountsOfAnEighth(step_deg);
  return counts >= 1.0 ? std::fmod(std::round(within_deg / step_deg), counts) : 0.0;
}

// Between two steps a rest is at either of them. An eighth of a turn ends where it begins.
Flicker FlickerOf(const RestFlicker& rests) {
  std::vector<RestFlicker::AtCount> places;
  double last = kMissing;
  for (const auto& [count, here] : rests.by_count) {
    if (!(count - last < 1.5)) places.emplace_back();
    places.back() += here;
    last = count;
  }
  if (places.empty()) return {};
  const double first = rests.by_count.begin()->first;
  if (places.size() > 1 && first + CountsOfAnEighth(rests.step_deg) - last < 1.5) {
    places.front() += places.back();
    places.pop_back();
  }
  std::vector<double> squares;
  for (const RestFlicker::AtCount& place : places)
    squares.push_back(place.square_sum / place.rests);
  const double square = squares.size() == 2 ? 0.5 * (squares[0] + squares[1]) : Median(squares);
  return {square, squares.size()};
}

// From place to place: two standard deviations and more. Two steps alone scatter by 1/4 at most,
// and a short rest may seem to by more; where the readings are on three steps and more the place
// makes little of it.
double Doubt(const Flicker& flicker) {
  constexpr double kOfPlaces = 0.22, kOfManySteps = 0.05, kManySteps = 0.4;
  return (flicker.square > kManySteps ? kOfManySteps : kOfPlaces) /
         std::sqrt(static_cast<double>(flicker.places));
}

// Noise of one reading [steps^2]: over evenly spread places the readings scatter by the square
// s / pi^(1/2) as long as the noise s is below 0.3, and by s^2 + 1/12 above.
double NoiseBehind(double flicker) {
  constexpr double kLittle = 0.17;
  const double square = std::max(0.0, flicker);
  return square < kLittle ? std::numbers::pi * square * square : square - 1.0 / 12.0;
}

// exp(-4 pi^2 s^2), with noise of s steps (Widrow and Kollar, Quantization Noise, 2008, 4.2).
double LeftByNoise(double noise2) {
  return std::exp(-4.0 * std::numbers::pi * std::numbers::pi * noise2);
}

double LeastOf(const Flicker& flicker) { return flicker.square - Doubt(flicker); }

// With so much noise readings change even where an axis rests in the middle of a step: a half of
// that is hardly missed by chance.
bool TooStillFor(double noise2, const Flicker& flicker) {
  return flicker.square < 0.5 * std::erfc(0.5 / std::sqrt(2.0 * noise2));
}

// What all show, where the recording's own rests agree with it; one without rests does not.
double LeftTogether(const Flicker& own, const Flicker& all) {
  const double least = LeastOf(all);
  const bool agree = least >= LeastOf(own) && least <= own.square + Doubt(own) &&
                     !TooStillFor(NoiseBehind(least), own);
  return agree ? LeftByNoise(NoiseBehind(least)) : LeftOfRounding(own.square, own.places);
}

// A step is the least change of a reading, which a table gives in a few digits.
bool SameStep(const RestFlicker& one, const RestFlicker& other) {
  constexpr double kPart = 0.01;
  return std::fabs(one.step_deg - other.step_deg) <= kPart * one.step_deg;
}

// Of recordings of one step each, what all of them show.
std::vector<RestFlicker> ByStep(std::span<const RestFlicker> recordings) {
  std::vector<RestFlicker> out;
  for (const RestFlicker& recording : recordings) {
    auto same = std::ranges::find_if(
        out, [&](const RestFlicker& other) { return SameStep(other, recording); });
    if (same == out.end()) same = out.insert(out.end(), {recording.step_deg, {}});
    for (const auto& [count, here] : recording.by_count) same->by_count[count] += here;
  }
  return out;
}

}  // namespace

RestFlicker::AtCount& RestFlicker::AtCount::operator+=(const AtCount& other) {
  square_sum += other.square_sum;
  rests += other.rests;
  return *this;
}

RestFlicker FlickerAtRest(const std::vector<Node>& nodes, const std::vector<std::size_t>& rest_of,
                          std::size_t axis, double step_deg) {
  if (!(step_deg > 0.0) || !std::isfinite(step_deg)) return {};
  RestFlicker out{step_deg, {}};
  for (const NodeRange& rest : RangesOfRests(rest_of)) {
    const double square = FlickerIn(rest, nodes, axis, step_deg);
    const double angle_deg = nodes[rest.begin].table_deg[axis];
    if (!std::isfinite(square) || !std::isfinite(angle_deg)) continue;
    out.by_count[CountOf(angle_deg, step_deg)] += {square, 1.0};
  }
  return out;
}

double LeftOfRounding(double flicker, std::size_t places) {
  return std::isfinite(flicker) ? LeftByNoise(NoiseBehind(LeastOf({flicker, places}))) : 1.0;
}

double LeftOfRounding(const RestFlicker& rests) {
  if (!(rests.step_deg > 0.0)) return 0.0;
  const Flicker own = FlickerOf(rests);
  return LeftOfRounding(own.square, own.places);
}

// The first harmonic of a saw tooth of steps q is q / pi; noise leaves the root of its variance.
double WaveOfRounding_deg(double step_deg, double left) {
  if (!(step_deg > 0.0) || !std::isfinite(step_deg)) return 0.0;
  return step_deg / std::numbers::pi * std::sqrt(left);
}

double WaveOfRounding_deg(std::span<const RestFlicker> recordings) {
  double most_deg = 0.0;
  for (const RestFlicker& together : ByStep(recordings)) {
    const Flicker all = FlickerOf(together);
    for (const RestFlicker& recording : recordings) {
      if (!SameStep(together, recording)) continue;
      const double left = LeftTogether(FlickerOf(recording), all);
      most_deg = std::max(most_deg, WaveOfRounding_deg(recording.step_deg, left));
    }
  }
  return most_deg;
}

}  // namespace gyrobench::calibration
