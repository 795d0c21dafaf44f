// What a calibration is worth on a recording that it was not made from.
#pragma once

#include <array>

#include "calibration/artefact/calibration_file.h"
#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {

// Records `spec`, corrects it by `calibration` with the sensor's own columns alone, and whitens
// what the corrected rates say more than the reference, by the true noise (which passes the inverse
// of the true M as well). RMS of x, y, z.
std::array<double, 3> CorrectedElsewhere(const TrialSpec& spec,
                                         const calibration::Calibration& calibration);

}  // namespace gyrobench::blind_trials
