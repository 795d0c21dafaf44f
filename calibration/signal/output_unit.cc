#include "calibration/signal/output_unit.h"

#include "base/geometry.h"

namespace gyrobench::calibration {
namespace {

// LSB per deg/s of 250 deg/s in 16 bits (MPU-6050 data sheet 3.4, section 6.1).
constexpr double kUsualUnitsPerDeg_s = 131.0;

}  // namespace

std::string OutputUnit(const MeasurementInfo& info) {
  return info.gyro_unit == RateUnit::kLsb ? "LSB" : "deg/s";
}

std::string ColumnUnit(const MeasurementInfo& info) {
  return info.gyro_unit == RateUnit::kRadPerSecond ? "rad/s" : OutputUnit(info);
}

double NominalUnitsPerDegPerS(const MeasurementInfo& info) {
  if (info.gyro_unit != RateUnit::kLsb) return 1.0;
  const double nominal = info.gyro_units_per_deg_s.value_or(kMissing);
  return nominal > 0 ? nominal : kMissing;
}

double RoughUnitsPerDeg_s(const MeasurementInfo& info) {
  switch (info.gyro_unit) {
    case RateUnit::kLsb:
      return info.gyro_units_per_deg_s.value_or(kUsualUnitsPerDeg_s);
    case RateUnit::kRadPerSecond:
      return kRadPerDeg;
    case RateUnit::kDegPerSecond:
      break;
  }
  return 1.0;
}

}  // namespace gyrobench::calibration
