// When the sensor was held still: from the gyro and the accelerometer alone.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "calibration/hold/epoch.h"

namespace gyrobench::calibration {

// Epochs first .. last - 1.
struct EpochRange {
  std::size_t first = 0, last = 0;
};

struct RestSearch {
  std::vector<EpochRange> rests;
  // Zero-rate offset, about [output units].
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();
  // Rate about the offset, root mean square over half a second: the level that parts rest from
  // motion, and the medians of both [output units].
  double threshold = kMissing, rest_level = kMissing, motion_level = kMissing;
};

// No level is fixed: the logarithm of the rate about its offset has two heaps, rest and motion, and
// the level that parts them best is Otsu's (IEEE Trans. SMC 9, 1979: most variance between the
// heaps). A rest ends where the rate leaves its own usual level, where the accelerometer trembles
// much more than in most rests, and where anything cannot be used. A rest in which the sensor turns
// slowly is cut into pieces that turn by `widest_turn` times the level of motion times one second.
// No rest at all where the heaps are not apart: everything rests, or everything moves.
RestSearch FindRests(std::span<const Epoch> epochs);

}  // namespace gyrobench::calibration
