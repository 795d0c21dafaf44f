// Records on disk: one folder a run, <records>/<run_id>/, with
//   events.lcmlog   every message of the run, in order: the source of truth
//   run.json        who, what, when, configuration and script as run, outcome
//   result.json     the last results
//   trace.json      the trace at its end
//   report.html     the report of that trace
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"
#include "base/run_facts.h"

namespace gyrobench::recording {

inline constexpr const char* kEventLogName = "events.lcmlog";
inline constexpr const char* kRunJsonName = "run.json";
inline constexpr const char* kResultJsonName = "result.json";
inline constexpr const char* kTraceJsonName = "trace.json";
inline constexpr const char* kReportName = "report.html";

// Keys of run.json that several read.
inline constexpr const char* kRunIdKey = "run_id";
inline constexpr const char* kOutcomeKey = "outcome";
// The run that this one has taken up, and the one that has taken up this one.
inline constexpr const char* kResumedFromKey = "resumed_from";
inline constexpr const char* kResumedByKey = "resumed_by";
// Outcomes of a run that is on, and of one whose daemon ended with it.
inline constexpr const char* kRunningOutcome = "running";
inline constexpr const char* kInterruptedOutcome = "interrupted";
inline constexpr const char* kStartUtimeKey =
    "start_utime";                               // integer, microseconds since the epoch
inline constexpr const char* kSaidKey = "said";  // by the procedure: a list of {t_s, text}
// Of a run that commissioned the stand: notes, a list, and findings, each with what, reason and
// corrections; these have key, value and was.
inline constexpr const char* kWiringKey = "wiring";
inline constexpr const char* kMeasurementKey = "measurement";  // recording/measurement_info_json.h

// Throws DataError, with what to do, where the folder of records is not there and cannot be made,
// or cannot be written to. Leaves nothing behind.
void RequireWritable(const std::filesystem::path& records);

// The folder of one run.
class RunDirectory {
 public:
  // Makes the folder of a new run. Its id is UTC and the procedure's name, 20261121-153012-scale,
  // and -02, -03 ... after it where that is taken. Throws DataError, with what to do, when the
  // records folder cannot be made or written.
  static RunDirectory Create(const std::filesystem::path& records, std::string_view procedure,
                             Utime start);
  // An existing record. Throws DataError when `folder` holds neither an event log nor a run.json.
  static RunDirectory Open(const std::filesystem::path& folder);

  const std::string& run_id() const { return run_id_; }
  const std::filesystem::path& folder() const { return folder_; }
  // Whether a process lives that has it of Create: so a record that says `running` is told from one
  // whose daemon is gone, as long as it is asked before the record is read. True as well where the
  // file system cannot tell.
  bool IsBeingMade() const;
  std::filesystem::path EventLog() const { return folder_ / kEventLogName; }
  std::filesystem::path RunJson() const { return folder_ / kRunJsonName; }
  std::filesystem::path ResultJson() const { return folder_ / kResultJsonName; }

  void WriteRun(const nlohmann::json& run) const;
  void WriteResult(const nlohmann::json& result) const;
  nlohmann::json ReadRun() const;
  nlohmann::json ReadResult() const;

 private:
  RunDirectory(std::string run_id, std::filesystem::path folder);
  std::string run_id_;
  std::filesystem::path folder_;
  std::shared_ptr<const int> hold_;  // of who makes it: the kernel lets go however the process ends
};

// A key that is absent or null leaves its fact empty; a value of another kind, or a time that no
// clock gives, does as well, and is a sentence of RunFacts::damage.
RunFacts RunFactsFromJson(const nlohmann::json& run);
// The same of the run.json in `folder`; that it is not there, or is no JSON, is damage as well.
RunFacts ReadRunFacts(const std::filesystem::path& folder);

// Writes `value` so that a reader, or a crash at any moment, finds the old file or the new one and
// never a part: temporary file, fsync, rename, fsync of the folder. Throws DataError.
void WriteJsonAtomically(const std::filesystem::path& file, const nlohmann::json& value);

// Throws DataError that names file and place of what cannot be read, or is nested over 100 deep.
nlohmann::json ReadJson(const std::filesystem::path& file);

// The records in a folder, oldest first by the last write of their event log. Folders that hold no
// record are passed over. Empty when the folder does not exist; throws DataError when it cannot be
// read.
std::vector<RunDirectory> ListRuns(const std::filesystem::path& records);

// The record that `name` means: "latest", a run id, the unique beginning of one, or the path of a
// record's folder or of a file in it. Throws DataError that lists what there is.
RunDirectory FindRun(const std::filesystem::path& records, const std::string& name);

// Every field under its own name; enumerations by name; axes as lists of those present; values that
// are not known are left out.
nlohmann::json ToJson(const MeasurementInfo& info);

// The inverse. A key that is absent keeps its default, a key that is not known here is passed over
// (a later version's). Throws DataError that names the key and what was expected.
MeasurementInfo MeasurementInfoFromJson(const nlohmann::json& json);

}  // namespace gyrobench::recording
