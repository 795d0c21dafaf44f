#include "calibration/intake_remarks.h"

#include <fmt/format.h>

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

}  // namespace gyrobench::calibration
