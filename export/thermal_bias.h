// The bias against temperature as the autopilots take it: a cubic in T - reference, in rad/s.
#pragma once

#include <array>
#include <string>

#include "export/linear_model.h"
#include "export/text.h"

namespace gyrobench::exporting {

using Cubic = std::array<double, 4>;  // c0 + c1 d + c2 d^2 + c3 d^3

// For a rate in rad/s as a driver gives it by the nominal sensitivity, xi / s0:
//   rate - offset(T),   offset(T) = sum_k coefficients[k] (T - reference)^k   [rad/s]
// The offset is the polynomial b(T) and every effect of the temperature alone. Where that is no
// cubic, the cubic is its best fit over the range, and a note says by how much it is off.
struct ThermalBias {
  // NaN where the calibration saw no temperatures: the cubics are constants.
  TemperatureRange range;
  double reference_degC = kMissing;
  std::array<Cubic, 3> coefficients_rad_s = {};  // 0 for an axis that is not there
  Lines notes;                                   // what the autopilots cannot hold, matrix and all

  // At a temperature held within the range [rad/s].
  Vector3 OffsetAt(double temperature_degC) const;
};

// `reference_degC`: where the autopilot fixes it, else NaN for the middle of the range. Throws
// DataError.
ThermalBias MakeThermalBias(const calibration::Calibration& calibration, double reference_degC);

// What is said above the parameters of every autopilot: origin, the autopilot's `formula`, frame
// and the driver's sensitivity, validity, offsets at three temperatures as a worked example,
// `notes`.
Lines AutopilotLines(const std::string& autopilot, const calibration::Calibration& calibration,
                     const Origin& origin, const ThermalBias& bias, const Lines& formula,
                     const Lines& notes);

}  // namespace gyrobench::exporting
