// What the steps of an encoder make of the angle of an axis that turns, by how its readings flicker
// while it stands still.
#pragma once

#include <cstddef>
#include <map>
#include <span>
#include <vector>

namespace gyrobench::calibration {

struct Node;

// The readings of one axis in the rests of one recording.
struct RestFlicker {
  struct AtCount {
    double square_sum = 0.0;  // of one reading's mean square in each rest, in squares of a step
    double rests = 0.0;

    AtCount& operator+=(const AtCount& other);
  };
  // Of the encoder, as the readings show it; 0: nothing is rounded.
  double step_deg = 0.0;
  // By the count, within an eighth of a turn, that a rest begins with.
  std::map<double, AtCount> by_count;
};

// Of one axis. Nothing is rounded where the step is no number above 0. `rest_of`: index of each
// node's rest, or kNoRest.
RestFlicker FlickerAtRest(const std::vector<Node>& nodes, const std::vector<std::size_t>& rest_of,
                          std::size_t axis, double step_deg);

// What noise leaves of the rounding's error, as a part of its variance. `flicker`: mean square of
// one reading, rounded as it is, while the axis rests, in squares of a step; NaN: not known. At few
// `places` it may rest on the edges between two steps, where the least noise makes the readings
// flicker, or on none: the least that the noise may be counts.
double LeftOfRounding(double flicker, std::size_t places);
// The same; 1 where the axis never rests, and 0 where nothing is rounded.
double LeftOfRounding(const RestFlicker& rests);

// Amplitude of the wave that rounding to steps of so much adds to an angle at even speed, of which
// readings at even times may make one of any number of periods a turn. 0 where nothing is rounded.
// `left`: LeftOfRounding.
double WaveOfRounding_deg(double step_deg, double left);

// The largest such wave of one axis in recordings that are traced together. Those of one step are
// taken to be of one encoder with one noise, which the rests of all of them tell better than those
// of one; but for a recording whose own rests contradict that, and for one that never rests, of
// which nothing is known. ReadingErrors judges each recording by itself.
double WaveOfRounding_deg(std::span<const RestFlicker> recordings);

}  // namespace gyrobench::calibration
