// What the steps of an encoder make of the angle of an axis that turns, by how its readings flicker
// while it stands still.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gyrobench::calibration {

// The readings of one axis in the rests of one recording.
struct RestFlicker {
  // Rests at one place within an eighth of a turn, in steps of the encoder.
  struct Place {
    double place = 0.0;
    double square_sum = 0.0;  // of one reading's mean square in each rest, in squares of a step
    double rests = 0.0;
  };
  double step_deg = 0.0;      // of the encoder; 0: nothing is rounded
  std::vector<Place> places;  // in ascending order
};

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

// The largest such wave of one axis in recordings that are traced together. An encoder of one step
// has one noise: what it is at least is known by the rests of all of them, unless those of one
// recording say otherwise.
double WaveOfRounding_deg(std::span<const RestFlicker> recordings);

}  // namespace gyrobench::calibration
