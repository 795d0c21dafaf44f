// One rest in a few numbers, and what lies between two rests.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calibration/hold/epoch.h"
#include "calibration/hold/rest_search.h"

namespace gyrobench::calibration {

// The sensor was held still. Angles of the gyro are integrals of its output [output units * s].
struct HeldRest {
  std::size_t recording = 0;
  EpochRange epochs;
  double begin_s = 0.0, end_s = 0.0;
  Eigen::Vector3d accel_g = Eigen::Vector3d::Zero();  // mean of the accelerometer's output
  Eigen::Vector3d angle = Eigen::Vector3d::Zero();    // int xi dt over the rest
  // Of a(t) - a(end) t / duration, what the sensor trembles by: mean over the rest, and root mean
  // square of its length.
  Eigen::Vector3d path_mean = Eigen::Vector3d::Zero();
  double path_rms = 0.0;
  // Density of white noise by Epoch::white_square, root mean square of the axes [output units
  // sqrt(s)].
  double white_density = kMissing;
  double temperature_degC = kMissing;

  double duration_s() const { return end_s - begin_s; }
};

enum class LinkKind {
  kTurn,     // the gyro saw all of it
  kLeftOut,  // the same power-on, but what the sensor did between is not known
  kApart,    // another power-on: another zero-rate offset
};

// From one rest to the next.
struct HeldLink {
  LinkKind kind = LinkKind::kTurn;
  EpochRange epochs;  // of the turn
  double begin_s = 0.0, end_s = 0.0;
  std::string because;  // why it is left out

  double duration_s() const { return end_s - begin_s; }
};

// Rests of all recordings in their order; links[k] leads from rests[k] to rests[k + 1].
struct HeldChain {
  std::vector<const HoldRecording*> recordings;
  std::vector<HeldRest> rests;
  std::vector<HeldLink> links;
};

// The motion between two rests: longest that is followed. A hand needs seconds; after longer the
// sensor was carried about.
inline constexpr double kLongestTurn_s = 60.0;

HeldRest ReduceRest(std::span<const Epoch> epochs, const EpochRange& range);
HeldChain MakeChain(std::span<const HoldRecording* const> recordings,
                    std::span<const RestSearch> searches);

}  // namespace gyrobench::calibration
