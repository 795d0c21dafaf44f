// Sets the drives that a scan of the lines found as the stand file says.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "base/clock.h"
#include "cli/options.h"
#include "config/stand_config.h"
#include "drivers/line_scan.h"

namespace gyrobench::cli {

// Shows what differs, asks, writes, and asks the drives once more, whose part of `reports` is then
// as they are now. Only drives of the stand file at their line's own setting. What was written, for
// --json: [{"bus", "unit", "device", "parameter", "from", "to", "saved", "error"}], with a sentence
// as the error of a drive that failed. Throws UsageError where there is nobody to ask, and with
// --yes where drives may have been taken one for the other.
nlohmann::ordered_json WriteDriveSettings(const config::StandConfig& stand, const Options& options,
                                          Clock& clock, Clock::Participant& participant,
                                          std::vector<drivers::LineReport>* reports);

}  // namespace gyrobench::cli
