// A calibration of three axes, and the corrector's word on it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/geometry.h"
#include "calibration/artefact/calibration_file.h"
#include "export/exporter.h"

namespace gyrobench::exporting {

inline constexpr double kUnits = 131.0;  // LSB per deg/s
inline constexpr Vector3 kGravity = {0.6, 0.0, 0.8};

// Cubic bias, misalignment of some percent, 20 .. 30 degC, 45 deg/s, noise; no effects.
calibration::Calibration ThreeAxes();
// The same with a matrix of one.
calibration::Calibration WithoutMatrix();
calibration::ModelTerm CatalogueTerm(const std::string& id, std::vector<double> coefficients,
                                     std::vector<double> nonlinear = {});
calibration::ModelTerm ComposedTerm(std::vector<std::string> factors, double coefficient);
calibration::ModelTerm CurveTerm(const std::string& factor, std::vector<double> knots,
                                 std::vector<double> values);

// In the format of that name.
Exported Write(const calibration::Calibration& calibration, std::string_view format,
               const std::string& target = "gyro.h");

// One sample of a sensor whose state stands still.
struct State {
  Vector3 xi = {};
  double temperature_degC = 25.0;
  double t_s = 0.0;  // since power-on
};
// Outputs about and beyond the range of rates, at one temperature, 0.1 s apart.
std::vector<State> StatesAt(double temperature_degC);
// What `gyrobench apply` makes of them [deg/s].
std::vector<Vector3> Corrected(const calibration::Calibration& calibration,
                               const std::vector<State>& states);

// Words as they follow each other, without the marks and ends of comment lines.
std::string Flat(const std::string& text);
// The numbers between `before`, its first occurrence in the flat text, and what is no number.
std::vector<double> NumbersAfter(const std::string& text, const std::string& before);

}  // namespace gyrobench::exporting
