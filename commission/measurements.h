// What a stand is seen to do while each of its drives turns a little.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/geometry.h"

namespace gyrobench::commission {

inline double Length(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

// An encoder's registers as they came, that of the lower address first; one register leaves the
// second at 0.
using Words = std::array<std::uint16_t, 2>;

// One move of one drive. Axes, drives and encoders are counted as the stand file has them: the i-th
// drive is that of its i-th axis, whatever it really turns.
struct Move {
  enum class Kind {
    kFirst,  // how far the table turns for what is commanded
    kLarge,  // by which the axis is judged: twice one way from its mark, and twice back
    kSmall   // with another axis turned away from its mark: its direction
  };
  Kind kind = Kind::kFirst;
  std::size_t drive = 0;
  // Of the table, by this drive's configuration with the pulses a turn that it said itself.
  double commanded_deg = 0.0;
  std::vector<double> begin_deg = {};  // where each drive had been commanded to, before
  // By the gyro: the integral of its rates less those at rest, in the sensor frame, with the nominal
  // scale.
  Vector3 turned_deg = {};
  std::vector<Words> before = {}, after = {};  // of each encoder
};

struct Measurements {
  std::vector<int> pulses_per_turn;  // that each drive says
  // Of the accelerometer with the axes at their marks, sensor frame [g]; 0 where it felt nothing.
  Vector3 specific_force_g = {};
  std::vector<Move> moves;  // in the order in which they were made
  // By how much each encoder's value is older than the gyro's at the same time, its filter taken off
  // [s], in the moves of the drive that turns it, with the standard error. Empty where none did.
  struct Delay {
    double value_s = 0.0, std_error_s = 0.0;
  };
  std::vector<std::optional<Delay>> delays;
};

}  // namespace gyrobench::commission
