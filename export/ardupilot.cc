// Format `ardupilot`: INS_TCAL1_*, as ArduPilot's AP_InertialSensor evaluates them
// (docs/calibration.md has the sources), in the file format of its ground stations.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "export/formats.h"
#include "export/text.h"
#include "export/thermal_bias.h"

namespace gyrobench::exporting {
namespace {

// Both are ArduPilot's.
constexpr double kReference_degC = 35.0;
constexpr double kScale = 1e6;

std::string Row(const std::string& name, const std::string& value) {
  return name + "," + value + "\n";
}

std::string ThermalRows(const ThermalBias& bias) {
  std::string rows = Row("INS_TCAL1_ENABLE", "1") +
                     Row("INS_TCAL1_TMIN", Fixed(bias.range.low_degC)) +
                     Row("INS_TCAL1_TMAX", Fixed(bias.range.high_degC));
  for (std::size_t k = 1; k < 4; ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      rows += Row(fmt::format("INS_TCAL1_GYR{}_{}", k, "XYZ"[c]),
                  Fixed(kScale * bias.coefficients_rad_s[c][k]));
    }
  }
  return rows;
}

std::string OffsetRows(const Vector3& offset_rad_s) {
  std::string rows;
  for (std::size_t c = 0; c < 3; ++c)
    rows += Row(fmt::format("INS_GYROFFS_{}", "XYZ"[c]), Fixed(offset_rad_s[c]));
  return rows;
}

Lines FormulaLines(bool thermal) {
  if (!thermal) return {"Formula: rate - INS_GYROFFS   [rad/s]"};
  return {"Formula, of the axes X, Y, Z, with T and CALTEMP held within TMIN .. TMAX:",
          "  P(d) = (GYR1 d + GYR2 d^2 + GYR3 d^3) / 10^6",
          "  rate - P(T - 35) + P(CALTEMP - 35) - INS_GYROFFS",
          "GYRk: INS_TCAL1_GYRk; CALTEMP: INS_GYR1_CALTEMP.",
          "Units: rate and INS_GYROFFS rad/s, temperatures degC, GYRk 10^-6 rad/s/degC^k."};
}

void AddNotes(bool thermal, Lines* notes) {
  if (!thermal) {
    notes->push_back(
        "the calibration saw no temperature: no thermal parameters (INS_TCAL1_*); the constant "
        "offset is written instead, as INS_GYROFFS_X, _Y, _Z");
  }
  notes->push_back(
      "ArduPilot measures INS_GYROFFS and INS_GYR1_CALTEMP anew at each start, unless INS_GYR_CAL "
      "is 0");
  notes->push_back(
      "the accelerometer's INS_TCAL1_ACC* are not written: they stay as they are; for another than "
      "the first IMU change the 1 after INS_TCAL and INS_GYR, and GYROFFS to GYR2OFFS");
}

}  // namespace

Exported WriteArduPilot(const calibration::Calibration& calibration, const Origin& origin) {
  const ThermalBias bias = MakeThermalBias(calibration, kReference_degC);
  const bool thermal = bias.range.known();
  Exported out;
  out.notes = bias.notes;
  out.warnings = SetToZero(calibration);
  AddNotes(thermal, &out.notes);
  out.text = Commented(
      AutopilotLines("ArduPilot", calibration, origin, bias, FormulaLines(thermal), out.notes),
      "# ");
  // Where the polynomial and INS_GYROFFS meet; any within the range would do.
  const double caltemp_degC =
      std::fmin(std::fmax(kReference_degC, bias.range.low_degC), bias.range.high_degC);
  if (thermal) out.text += ThermalRows(bias) + Row("INS_GYR1_CALTEMP", Fixed(caltemp_degC));
  out.text += OffsetRows(bias.OffsetAt(caltemp_degC));
  return out;
}

}  // namespace gyrobench::exporting
