#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "daemon/run_record.h"
#include "recording/event_log.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {
namespace {

// 0 where none can be read.
Utime LastEventOf(const recording::RunDirectory& run) {
  Utime last = 0;
  if (!std::filesystem::exists(run.EventLog())) return last;
  recording::EventLogReader reader(run.EventLog());
  recording::LogEvent event;
  while (reader.Next(event)) last = std::max(last, event.utime);
  return last;
}

// False where it was closed by who began it.
bool CloseIfInterrupted(const recording::RunDirectory& run) {
  if (!std::filesystem::exists(run.RunJson())) return false;
  nlohmann::json description = run.ReadRun();
  if (!description.is_object() || description.value("outcome", "") != kRunningOutcome) return false;
  const Utime last = LastEventOf(run);
  DescribeInterruption(description, last);
  run.WriteRun(description);
  return true;
}

}  // namespace

std::vector<std::string> CloseInterruptedRuns(const std::filesystem::path& records) {
  std::vector<std::string> closed;
  try {
    for (const recording::RunDirectory& run : recording::ListRuns(records)) {
      try {
        if (CloseIfInterrupted(run)) closed.push_back(run.run_id());
      } catch (const std::exception& error) {
        spdlog::warn("record {}: {}", run.run_id(), error.what());
      }
    }
  } catch (const DataError& error) {
    spdlog::warn("{}", error.what());
  }
  return closed;
}

}  // namespace gyrobench::daemon
