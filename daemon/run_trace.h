// The trace of a run: made while nothing moves, kept in its record.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "calibration/estimators/results.h"
#include "calibration/signal/collector.h"
#include "calibration/trace/trace.h"
#include "procedures/engine/bench.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {

// nullopt, with a line in the daemon's log, when there is nothing that could be traced.
// For a procedure on its way, which reads verdicts, or for the record: the curves of the report,
// and the method tried on what it has not seen, which takes as long again.
enum class TraceFor { kProcedure, kRecord };
std::optional<calibration::Traced> TraceRun(const calibration::Recording& recording,
                                            TraceFor purpose);

procedures::AxisVerdict VerdictOf(const calibration::ChannelTrace& channel);

// Writes trace.json and report.html into a record whose log is closed. `run`: what is its run.json.
// A report that cannot be written is a line in the daemon's log: `gyrobench report` makes it again.
// Throws DataError when trace.json cannot be written.
void WriteTrace(const recording::RunDirectory& directory, const nlohmann::json& run,
                const calibration::TraceResult& trace, const calibration::AnalysisResult& analysis);

}  // namespace gyrobench::daemon
