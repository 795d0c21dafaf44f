// The worked example of a written file, computed by the corrector, not by what it is to show.
#pragma once

#include "calibration/artefact/calibration_file.h"
#include "calibration/signal/geometry.h"

namespace gyrobench::exporting {

// A sensor at one temperature that turns steadily, lying as `gravity_g` says, just switched on.
struct Example {
  calibration::Vector3 xi = {};
  double temperature_degC = 25.0;
  calibration::Vector3 gravity_g = {0.6, 0.0, 0.8};
  calibration::Vector3 rate_deg_s = {};  // corrected, frame S
};

// Within the range of the calibration. Throws DataError where that has no correction.
Example WorkedExample(const calibration::Calibration& calibration);

// "2.5, -1, 0.25": as many digits as bring the values back.
std::string ListOf(const calibration::Vector3& values);

}  // namespace gyrobench::exporting
