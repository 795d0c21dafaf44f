// A small record, written message by message as the daemon does.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "base/clock.h"
#include "base/measurement.h"

namespace gyrobench::recording {

struct RecordPlan {
  int blocks = 100;  // of 10 samples, 5 ms apart
  bool with_run_json = true;
  std::string channel_prefix = "BENCH_7";
  std::string run_id = "20261121-153012-scale";
  Utime start = 1'795'000'000'123'457;  // no round number, so that a lost microsecond shows
  std::optional<Utime> power_on_utime;
  int restart_at_block = -1;  // the unit's boot counter is one more from there on
};

// What a record of the plan says of itself.
MeasurementInfo PlannedInfo(const RecordPlan& plan);

// Makes the folder with its log and run.json; between the run's messages there are some of before
// the run, of another run and on other channels.
void BuildRecord(const std::filesystem::path& folder, const RecordPlan& plan);

// The bytes of a log as other loggers write it, and as gyrobench 0.1 did.
std::string WithoutChecksums(const std::filesystem::path& log);

}  // namespace gyrobench::recording
