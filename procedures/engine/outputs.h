// Fan and heater: switched by the stand where it can, by the operator where it cannot.
#pragma once

#include <string>
#include <vector>

#include "procedures/engine/bench.h"

namespace gyrobench::procedures {

// What an operator is asked where the stand has not the output; `id` is "fan_on", "heater_off" ...
Question SwitchQuestion(const std::string& output, bool on);

// All that may be switched.
const std::vector<std::string>& KnownOutputs();

}  // namespace gyrobench::procedures
