// The trace of a run: made while nothing moves, kept in its record.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "calibration/collector.h"
#include "calibration/results.h"
#include "calibration/trace/trace.h"
#include "procedures/engine/bench.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {

// nullopt, with a line in the daemon's log, when there is nothing that could be traced.
// `curves`: those of the report as well.
std::optional<calibration::Traced> TraceRun(const calibration::Recording& recording, bool curves);

procedures::AxisVerdict VerdictOf(const calibration::ChannelTrace& channel);

// Writes trace.json and report.html into a record whose log is closed. `run`: what is its run.json.
// A report that cannot be written is a line in the daemon's log: `gyrobench report` makes it again.
// Throws DataError when trace.json cannot be written.
void WriteTrace(const recording::RunDirectory& directory, const nlohmann::json& run,
                const calibration::TraceResult& trace, const calibration::AnalysisResult& analysis);

}  // namespace gyrobench::daemon
