#include "calibration/state/rounding_wave.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "base/robust.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// Of one reading, in squares of a step: the median over the places where the axis rested, of which
// one may be a slow turn that passes for a rest, and how many these are. NaN where it never rested.
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

// Where in its step an axis rests: poses that are an eighth of a turn apart are so by a whole
// number of the steps of an encoder of some bits, and count as one place.
double PlaceOf(double angle_deg, double step_deg) {
  constexpr double kEighth_deg = 45.0;
  const double within_deg = angle_deg - kEighth_deg * std::floor(angle_deg / kEighth_deg);
  return std::fmod(std::round(within_deg / step_deg), std::round(kEighth_deg / step_deg));
}

// Between two steps a rest is at either of them.
Flicker MedianOf(const std::vector<RestFlicker::Place>& places) {
  std::vector<double> squares;
  double last = kMissing, square_sum = 0.0, rests = 0.0;
  for (const RestFlicker::Place& place : places) {
    if (!(place.place - last < 1.5)) {
      square_sum = rests = 0.0;
      squares.push_back(0.0);
    }
    square_sum += place.square_sum;
    rests += place.rests;
    squares.back() = square_sum / rests;
    last = place.place;
  }
  if (squares.empty()) return {};
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

// exp(-4 pi^2 s^2), with noise of s steps (Widrow and Kollar, Quantization Noise, 2008, 4.2). Over
// evenly spread places the readings scatter by the square s / pi^(1/2) as long as s is below 0.3,
// and by s^2 + 1/12 above.
double LeftBesideFlicker(double least) {
  constexpr double kFlickers = 0.17;
  const double noise2 = least < kFlickers ? std::numbers::pi * least * least : least - 1.0 / 12.0;
  return std::exp(-4.0 * std::numbers::pi * std::numbers::pi * noise2);
}

bool SameStep(const RestFlicker& one, const RestFlicker& other) {
  constexpr double kPart = 1e-6;
  return std::fabs(one.step_deg - other.step_deg) <= kPart * one.step_deg;
}

Flicker FlickerTogether(std::span<const RestFlicker> recordings, const RestFlicker& like) {
  std::map<double, RestFlicker::Place> together;
  for (const RestFlicker& recording : recordings) {
    if (!SameStep(like, recording)) continue;
    for (const RestFlicker::Place& place : recording.places) {
      RestFlicker::Place& here = together[place.place];
      here.place = place.place;
      here.square_sum += place.square_sum;
      here.rests += place.rests;
    }
  }
  std::vector<RestFlicker::Place> places;
  for (const auto& [key, place] : together) places.push_back(place);
  return MedianOf(places);
}

double LeftTogether(const Flicker& own, const Flicker& all) {
  if (!std::isfinite(all.square)) return 1.0;
  double least = all.square - Doubt(all);
  if (std::isfinite(own.square)) {
    const double own_least = own.square - Doubt(own), own_most = own.square + Doubt(own);
    if (!(least >= own_least && least <= own_most)) least = own_least;
  }
  return LeftBesideFlicker(std::max(0.0, least));
}

}  // namespace

RestFlicker FlickerAtRest(const std::vector<Node>& nodes, const std::vector<std::size_t>& rest_of,
                          std::size_t axis, double step_deg) {
  if (!(step_deg > 0.0) || !std::isfinite(step_deg)) return {};
  std::map<double, RestFlicker::Place> places;
  for (const NodeRange& rest : RangesOfRests(rest_of)) {
    const double square = FlickerIn(rest, nodes, axis, step_deg);
    const double angle_deg = nodes[rest.begin].table_deg[axis];
    if (!std::isfinite(square) || !std::isfinite(angle_deg)) continue;
    RestFlicker::Place& here = places[PlaceOf(angle_deg, step_deg)];
    here.place = PlaceOf(angle_deg, step_deg);
    here.square_sum += square;
    here.rests += 1.0;
  }
  RestFlicker out{step_deg, {}};
  for (const auto& [key, place] : places) out.places.push_back(place);
  return out;
}

double LeftOfRounding(double flicker, std::size_t places) {
  const Flicker own{flicker, places};
  return std::isfinite(flicker) ? LeftBesideFlicker(std::max(0.0, flicker - Doubt(own))) : 1.0;
}

double LeftOfRounding(const RestFlicker& rests) {
  if (!(rests.step_deg > 0.0)) return 0.0;
  const Flicker own = MedianOf(rests.places);
  return LeftOfRounding(own.square, own.places);
}

double WaveOfRounding_deg(double step_deg, double left) {
  if (!(step_deg > 0.0) || !std::isfinite(step_deg)) return 0.0;
  return step_deg / std::numbers::pi * std::sqrt(left);
}

double WaveOfRounding_deg(std::span<const RestFlicker> recordings) {
  double most_deg = 0.0;
  for (const RestFlicker& recording : recordings) {
    const double left =
        LeftTogether(MedianOf(recording.places), FlickerTogether(recordings, recording));
    most_deg = std::max(most_deg, WaveOfRounding_deg(recording.step_deg, left));
  }
  return most_deg;
}

}  // namespace gyrobench::calibration
