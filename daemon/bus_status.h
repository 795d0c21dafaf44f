// What the control socket says of the stand's lines: docs/control-api.md.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "config/stand_config.h"
#include "drivers/line_figures.h"

namespace gyrobench::daemon {

// {"buses": [...]}: of each line how busy it is and what is expected of it, of each unit how often
// it was asked, how it answered, and how fast; since the daemon started, and of late.
nlohmann::json BusStatus(const config::StandConfig& stand,
                         const std::vector<drivers::LineFigures>& lines);

}  // namespace gyrobench::daemon
