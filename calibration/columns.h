// What the analysis keeps of a measurement: columns at about 10 Hz, the rests, and the stretches
// that must not be used. No sample is kept.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "base/measurement.h"
#include "calibration/geometry.h"

namespace gyrobench::calibration {

// The integral of the output at one time: z = int xi dt since the first sample, by the trapezoid
// rule [output unit * s], linear in between.
struct IntegralMark {
  double t_s = 0.0;
  Vector3 z = {};
};

// One node. Rotations are sums since the start.
struct Node {
  IntegralMark at;
  Vector3 rotation_deg = {};           // of the reference, about the sensor's axes
  Vector3 earth_deg = {};              // Earth's rotation about the sensor's axes; 0 when not known
  double temperature_degC = kMissing;  // mean since the node before
  Vector3 accel_g = {kMissing, kMissing, kMissing};  // mean since the node before
};

// A stretch in which the reference stood still and the gyro felt nothing.
struct Rest {
  IntegralMark begin, end;
  Vector3 rotation_deg = {};  // mean over the readings at rest
  double scatter_deg = 0.0;   // largest standard deviation of one reading among the axes
  std::int64_t readings = 0;
};

// A stretch that must not be used.
struct BadStretch {
  double begin_s = 0.0;
  double end_s = 0.0;
  std::array<bool, 3> channel = {true, true, true};
};

struct Columns {
  std::vector<Node> nodes;
  std::vector<Rest> rests;
  std::vector<BadStretch> bad;  // in order of begin_s
};

}  // namespace gyrobench::calibration
