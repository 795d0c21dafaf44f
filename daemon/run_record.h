// What a record says of its run, beside the events.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"
#include "config/stand_config.h"
#include "daemon/fault.h"
#include "daemon/live_bench.h"
#include "daemon/run_execution.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {

// run.json at the start of a run: who, what, when, configuration and script as run, versions.
nlohmann::json DescribeRun(const std::string& run_id, const procedures::Procedure& procedure,
                           const procedures::Parameters& parameters,
                           const config::StandConfig& stand, const MeasurementInfo& info,
                           Utime start);
// The same with its end. `failures`: what it ended by, the first first. `bench`: that the run had;
// nullptr where it came to none.
void DescribeEnd(nlohmann::json& run, Outcome outcome, const std::string& message,
                 const std::vector<Fault>& failures, const LiveBench* bench, Utime end);

using recording::kInterruptedOutcome;
using recording::kRunningOutcome;
// Of an interrupted run: somebody has said (gyrobench reset) that he has heard of it.
inline constexpr const char* kAcknowledgedKey = "acknowledged";
// The end of a run whose daemon did not live to describe it. `last`: time of the last event, 0
// where there is none.
void DescribeInterruption(nlohmann::json& run, Utime last);
struct InterruptedRun {
  recording::RunDirectory directory;
  std::string procedure;
  Utime last = 0;                           // time of its last event, 0 where there is none
  std::map<std::string, double> angle_deg;  // by the axis's name, the last that was recorded
};
// Closes each record in `records` whose run is still said to be on: their daemon was killed, or the
// power failed. Nobody else may write there (StandLock holds the folder). Returns these and those
// that an earlier start closed and nobody has acknowledged, oldest first. A record that cannot be
// closed is told in the log and left.
std::vector<InterruptedRun> CloseInterruptedRuns(const std::filesystem::path& records);
// From here on no start tells of it. What cannot be written is told in the log.
void Acknowledge(const InterruptedRun& run);
// Which run it was, where its axes stood then and stand now, and whether they moved between.
std::string DescribeInterruption(const InterruptedRun& run, const config::StandConfig& stand,
                                 const std::map<std::string, std::optional<double>>& now_deg);

// A run in which the unit started anew belongs to no one power-on: its name is taken back. Its
// times count on from the power-on at its begin. `power_on`: the name at its end.
void DescribePowerOnAtEnd(nlohmann::json& run, const std::string& power_on);

nlohmann::json ToJson(const procedures::Parameters& parameters);
// `object`: of name to value. Throws Error that names a value of another kind.
procedures::Parameters ParametersFrom(const nlohmann::json& object);
// "2026-11-21T15:30:12.000Z"
std::string IsoTime(Utime utime);

}  // namespace gyrobench::daemon
