// The part of a calibration that all formats start from: three axes, their matrix and its inverse.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "calibration/artefact/calibration_file.h"

namespace gyrobench::exporting {

inline constexpr const char* kAxisNames = "xyz";

//   xi_c / units_c = sum_j M_cj w_j + b_c(T) + effects_c      [deg/s]
// An axis that the calibration lacks has the row of the identity and no bias, one that was never
// turned a 1 on the diagonal: as `gyrobench apply` has it.
struct LinearModel {
  std::array<const calibration::ChannelModel*, 3> axes = {};  // nullptr: not in the calibration
  std::string unit;                                           // of xi
  Vector3 units_per_deg_s = {};
  Matrix3 m = {}, inverse = {};
};

// Refers to `calibration`. Throws DataError: channels of different units, no inverse.
LinearModel MakeLinearModel(const calibration::Calibration& calibration);

// One sentence for each axis that is not there, or was never turned, and each effect of the gyro
// that no correction can take off.
std::vector<std::string> WhatNoCorrectionHolds(const calibration::Calibration& calibration,
                                               const LinearModel& model);
// The terms of an applied effect that the data did not show, by name ("k_y" of bias.g_linear): the
// model holds them at 0, without an error.
std::vector<std::string> NotDetermined(const calibration::ChannelModel& model,
                                       const calibration::ModelTerm& term);
// One sentence for each axis and effect with such terms.
std::vector<std::string> SetToZero(const calibration::Calibration& calibration);
// One sentence for each axis whose row of M is not that of the identity, for targets without a
// matrix, with the largest rate that stays wrong.
std::vector<std::string> MatrixLeftOut(const LinearModel& model);

// The temperatures that all calibrated axes saw [degC]; NaN where none says. Throws DataError where
// they have none in common.
struct TemperatureRange {
  double low_degC = kMissing, high_degC = kMissing;
  bool known() const { return low_degC <= high_degC; }
};
TemperatureRange CommonTemperatures(const LinearModel& model);

}  // namespace gyrobench::exporting
