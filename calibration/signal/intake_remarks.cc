#include "calibration/signal/intake_remarks.h"

#include <fmt/format.h>

#include <algorithm>

namespace gyrobench::calibration {

std::vector<std::string> IntakeRemarks(const Recording& recording) {
  std::vector<std::string> remarks;
  for (const Defect& defect : recording.defects) {
    if (defect.kind != "unsigned_counts") continue;
    const bool accel = defect.where.starts_with("accel");
    remarks.push_back(fmt::format(
        "the counts of {} run through 32767 and 32768 and stay within 0 .. 65535: they are those "
        "of an unsigned converter, and its count of zero is contained in the {}; give it above the "
        "header, such as \"# {}_lsb_zero = 32768\"",
        defect.where, accel ? "specific force" : "zero-rate offset", accel ? "accel" : "gyro"));
  }
  return remarks;
}

std::string WithoutReference(const MeasurementInfo& info) {
  const auto all = [](const std::array<bool, 3>& axes) {
    return std::ranges::all_of(axes, [](bool present) { return present; });
  };
  if (all(info.gyro_present) && all(info.accel_present)) {
    return "poses held still with turns by hand between them are calibrated by gyrobench hold";
  }
  return "gyrobench hold calibrates without a reference, by poses held still, where the table has "
         "all three axes of gyro and accelerometer";
}

}  // namespace gyrobench::calibration
