#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {

std::string OutputUnit(const MeasurementInfo& info) {
  return info.gyro_unit == GyroUnit::kLsb ? "LSB" : "deg/s";
}

double NominalUnitsPerDegPerS(const MeasurementInfo& info) {
  if (info.gyro_unit != GyroUnit::kLsb) return 1.0;
  const double nominal = info.gyro_units_per_deg_s.value_or(kMissing);
  return nominal > 0 ? nominal : kMissing;
}

}  // namespace gyrobench::calibration
