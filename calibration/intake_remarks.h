// What the samples themselves say of how a measurement is described.
#pragma once

#include <string>
#include <vector>

#include "calibration/collector.h"

namespace gyrobench::calibration {

// Sentences without the measurement's name: counts of an unsigned converter whose zero nobody gave.
std::vector<std::string> IntakeRemarks(const Recording& recording);

}  // namespace gyrobench::calibration
