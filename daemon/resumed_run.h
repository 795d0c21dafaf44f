// A run whose daemon ended with it, as far as it had come: what a run needs that takes it up.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"
#include "config/stand_config.h"
#include "daemon/journal_bench.h"
#include "gyrobench/reflection.hpp"
#include "procedures/engine/procedure.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {

struct ResumedRun {
  recording::RunDirectory from;
  nlohmann::json description = {};  // its run.json
  MeasurementInfo info = {};
  procedures::Parameters parameters = {};
  Utime start = 0;
  std::vector<FinishedCommand> journal =
      {};                       // up to the last rest, and what followed without motion
  std::int64_t last_event = 0;  // number of that which ends the journal
  Utime last = 0;               // its time
  Utime end = 0;                // of the last event of all
  int segments_done = 0;
  // Of the table, when the last command of the journal was over, and at the begin of the run.
  std::map<std::string, double> angles_deg = {};
  std::map<std::string, double> begin_angles_deg = {};
};

// The run `run_id` of a folder of records, or with "latest" the last that was interrupted. Throws
// Error that says why it cannot be taken up: there is no such run, it was not interrupted, nobody
// has acknowledged it, it was taken up already, no command was over, or its record is damaged.
ResumedRun ReadInterrupted(const std::filesystem::path& records, const std::string& run_id);

// Throws Error where `procedure` is not the one that it ran, or is none that can be taken up, or
// stand or sensor are not what they were.
void RequireSame(const ResumedRun& run, const procedures::Procedure& procedure,
                 const config::StandConfig& stand, const MeasurementInfo& now);

// Notes in `run`, run.json of the run `run_id`, that it takes up `resumed`, and in that one's that
// it was. Throws DataError.
void DescribeResumption(nlohmann::json& run, const ResumedRun& resumed, const std::string& run_id);

// Of its measurement as one that goes on. Where the sensor was switched off and on since, it
// belongs to no one power-on.
MeasurementInfo ContinuedInfo(const ResumedRun& run, const MeasurementInfo& now,
                              bool same_power_on);
// By serial number, count of starts and moment. A virtual stand starts with its daemon.
bool IsSamePowerOn(const ResumedRun& run, const MeasurementInfo& now, bool virtual_stand);

// One after the other, what it had measured in commands that were over, then what says that another
// run takes it up. False at their end. Throws DataError.
std::function<bool(AnyMessage&)> MessagesBefore(const ResumedRun& run, bool same_power_on);

}  // namespace gyrobench::daemon
