// The noise of a gyro and of the reference that it is compared with: one model for every estimate.
#pragma once

#include <limits>

namespace gyrobench::calibration {

// Densities of the gyro's noise; NaN: not known. With b the zero-rate offset, W Wiener processes:
//   d angle = (rate + b) dt + N dW   angle random walk
//   d b     = K dW                   bias random walk
struct GyroNoise {
  double angle_random_walk_deg_sqrt_s = std::numeric_limits<double>::quiet_NaN();   // N
  double bias_random_walk_deg_s_sqrt_s = std::numeric_limits<double>::quiet_NaN();  // K
};

struct NoiseModel : GyroNoise {
  // s, standard deviation of one reference angle (of a stop, or of a 10 Hz node); NaN: not known.
  double reference_deg = std::numeric_limits<double>::quiet_NaN();
};

// The lists of their fields (base/json_fields.h), of the gyro's alone and of both.
template <typename Visitor>
void RandomWalks(Visitor& field, typename Visitor::template Field<GyroNoise>& noise) {
  field("angle_random_walk_deg_sqrt_s", noise.angle_random_walk_deg_sqrt_s);
  field("bias_random_walk_deg_s_sqrt_s", noise.bias_random_walk_deg_s_sqrt_s);
}
template <typename Visitor>
void Fields(Visitor& field, typename Visitor::template Field<NoiseModel>& noise) {
  RandomWalks(field, noise);
  field("reference_deg", noise.reference_deg);
}

}  // namespace gyrobench::calibration
