// Format `px4`: TC_G0_*, as PX4's module temperature_compensation evaluates them
// (docs/calibration.md has the sources), in the file format that QGroundControl loads.
#include <fmt/format.h>

#include <cmath>

#include "export/formats.h"
#include "export/text.h"
#include "export/thermal_bias.h"

namespace gyrobench::exporting {
namespace {

// Of MAV_PARAM_TYPE.
constexpr int kInt32 = 6, kReal32 = 9;

std::string Px4Row(const std::string& name, const std::string& value, int type) {
  return fmt::format("1\t1\t{}\t{}\t{}\n", name, value, type);
}

std::string Px4ThermalRows(const ThermalBias& bias) {
  std::string rows = Px4Row("TC_G_ENABLE", "1", kInt32);
  for (std::size_t k = 4; k-- > 0;) {
    for (std::size_t c = 0; c < 3; ++c)
      rows +=
          Px4Row(fmt::format("TC_G0_X{}_{}", k, c), Fixed(bias.coefficients_rad_s[c][k]), kReal32);
  }
  rows += Px4Row("TC_G0_TREF", Fixed(bias.reference_degC), kReal32);
  rows += Px4Row("TC_G0_TMIN", Fixed(bias.range.low_degC), kReal32);
  return rows + Px4Row("TC_G0_TMAX", Fixed(bias.range.high_degC), kReal32);
}

// They are taken off as well: 0 where the thermal ones hold all of the offset.
std::string Px4ConstantRows(const Vector3& offset_rad_s) {
  std::string rows;
  for (std::size_t c = 0; c < 3; ++c)
    rows += Px4Row(fmt::format("CAL_GYRO0_{}OFF", "XYZ"[c]), Fixed(offset_rad_s[c]), kReal32);
  return rows;
}

Lines Px4FormulaLines(bool thermal) {
  if (!thermal) {
    return {"Formula: rate - CAL_GYRO0_(X, Y, Z)OFF   [rad/s]"};
  }
  return {"Formula, of the axes i = 0, 1, 2 (x, y, z), with T held within TMIN .. TMAX:",
          "  d = T - TC_G0_TREF",
          "  offset_i = TC_G0_X0_i + TC_G0_X1_i d + TC_G0_X2_i d^2 + TC_G0_X3_i d^3",
          "  rate_i - offset_i - CAL_GYRO0_(X, Y, Z)OFF",
          "Units: rate and offset rad/s, temperatures degC, TC_G0_Xk_i rad/s/degC^k."};
}

void AddPx4Notes(bool thermal, Lines* notes) {
  if (!thermal) {
    notes->push_back(
        "the calibration saw no temperature: no thermal parameters (TC_G0_*); the constant offset "
        "is written instead, as CAL_GYRO0_XOFF, _YOFF, _ZOFF");
  }
  notes->push_back(fmt::format(
      "{} is not written: set it to the gyro's device id, as sensor_gyro says it; for another than "
      "the first gyro change the 0 after {}",
      thermal ? "TC_G0_ID" : "CAL_GYRO0_ID", thermal ? "TC_G and CAL_GYRO" : "CAL_GYRO"));
}

}  // namespace

Exported WritePx4(const calibration::Calibration& calibration, const Origin& origin) {
  const ThermalBias bias = MakeThermalBias(calibration, kMissing);
  const bool thermal = bias.range.known();
  Exported out;
  out.notes = bias.notes;
  out.warnings = SetToZero(calibration);
  AddPx4Notes(thermal, &out.notes);
  Lines about =
      AutopilotLines("PX4", calibration, origin, bias, Px4FormulaLines(thermal), out.notes);
  Append(&about, {"", "Vehicle-Id Component-Id Name Value Type"});
  out.text = Commented(about, "# ");
  if (thermal) out.text += Px4ThermalRows(bias);
  out.text += Px4ConstantRows(thermal ? Vector3{} : bias.OffsetAt(kMissing));
  return out;
}

}  // namespace gyrobench::exporting
