// From the channels' fits to one sensor.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "calibration/sensor/vector_calibration.h"
#include "calibration/signal/reference_error.h"

namespace gyrobench::calibration {

struct StateHistory;

// A channel's offset per g of gravity along x, y, z of N [deg/s/g].
struct GravityRow {
  Eigen::Vector3d value = Eigen::Vector3d::Constant(kMissing);
  Eigen::Vector3d std_error = Eigen::Vector3d::Constant(kMissing);  // without the Earth's
  // What the Earth's rotation, where it was not taken off, may be of the values [(deg/s/g)^2]; its
  // vertical part alone where the sensor's heading is not known.
  Eigen::Matrix3d earth_covariance = Eigen::Matrix3d::Zero();
  bool in_model = false;
  std::string because;  // why elements are not known
};

struct ChannelRow {
  std::size_t channel = 2;
  std::string unit;  // of xi
  double units_per_deg_s = 1.0;
  bool fitted = false;
  // Row of M about the sensor's x, y, z, then the shared parameters. NaN: the sensor never turned
  // about that axis. Errors as they are stated, grown where the residual is larger than the noise.
  Eigen::VectorXd values;
  Eigen::MatrixXd covariance;
  struct Name {
    std::string name, unit;
  };
  std::vector<Name> shared;  // of values from the fourth on
  GravityRow gravity;
  ReferenceError reference;  // not in the covariance
  // Errors that the rows share, in their covariance: what each value changes by with a standard
  // deviation of what another channel found of the reference (values.size() x these), and the names
  // of that, by which those of other rows are the same.
  Eigen::MatrixXd by_common;
  std::vector<std::string> common;
};

// `rows`: of the channels that were traced. The noise of channels is taken as independent: of the
// reference's, which they share, each feels what turns about its own axis. That holds of turns
// about one sensor axis; where an axis of the stand lies between two of the sensor's, both feel its
// encoder. Common errors (ChannelRow::common) are not; what they have in common with the channel
// that found them is not counted.
VectorCalibration MakeVectorCalibration(std::span<const ChannelRow> rows,
                                        std::span<const StateHistory> histories);

// Without the accelerometer.
VectorCalibration JoinChannels(std::span<const ChannelRow> rows);

}  // namespace gyrobench::calibration
