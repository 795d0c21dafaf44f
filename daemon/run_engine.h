// Runs: from a procedure's name to a closed record.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "daemon/run_execution.h"
#include "procedures/engine/dry_bench.h"
#include "procedures/engine/procedure.h"

namespace gyrobench::daemon {

struct StartedRun {
  std::string run_id;
  std::string record;
  double duration_s = 0.0;  // planned
};

// One run at a time, each in a thread of its own. Thread-safe.
class RunEngine {
 public:
  using Context = RunContext;
  explicit RunEngine(Context context);
  ~RunEngine();

  procedures::ProcedureLibrary& library() { return library_; }
  // Runs the procedure dry. Throws LimitError or Error with script and line.
  procedures::Plan Check(const std::string& procedure, const procedures::Parameters& parameters);
  // Checks, makes the record, and starts. Throws as Check does, StateError, DataError (record), and
  // DeviceError while a device is not well. Nothing has moved then. `stops`: that of RunControl when
  // the run was asked for, where that is not now; a run that was asked for before a stop does not
  // begin.
  StartedRun Start(const std::string& procedure, const procedures::Parameters& parameters,
                   std::optional<std::int64_t> stops = std::nullopt);
  // Takes up the run `run_id` of the records, whose daemon ended with it: its script is run again
  // on what its commands gave then, and from the first one that was not over on the bench. Throws
  // as Start does, and Error that says why it cannot be taken up.
  StartedRun Resume(const std::string& run_id, std::optional<std::int64_t> stops = std::nullopt);
  // Clears a latched fault and the drives' alarms; what is beyond a limit still is a fault again.
  // Throws StateError while a run is on.
  void Reset();
  // Stops every axis and switches every output off, in every state, and ends a run that is on or
  // that somebody is about to start. Does not wait.
  void Stop(const std::string& reason);
  // The same for good: no run begins any more, and no script is run dry.
  void StopForGood(const std::string& reason);
  // StopForGood, and waits for the end of the run.
  void Shutdown();
  std::optional<RunView> View() const;

 private:
  procedures::SandboxLimits LoadLimits() const;
  // Given up by StateError at the daemon's end, and where `stops` of RunControl is not what it was.
  procedures::Plan DryRunUntil(std::optional<std::int64_t> stops,
                               const procedures::Procedure& procedure,
                               const procedures::Parameters& parameters,
                               const std::vector<procedures::AxisFacts>& axes) const;
  // What was rehearsed begins.
  StartedRun Begin(std::int64_t stops, procedures::Procedure procedure,
                   procedures::Parameters parameters, procedures::Plan plan,
                   std::optional<ResumedRun> resumed = {});
  // From BeginRun to the run's thread. Whatever is thrown, RunControl::EndRun was called.
  RunView Launch(procedures::Procedure procedure, procedures::Parameters parameters,
                 procedures::Plan plan, std::unique_ptr<Clock::Participant> participant,
                 std::optional<ResumedRun> resumed);
  // Tells axes and outputs.
  void PostStop();
  procedures::DryOptions DryOptions() const;
  std::vector<procedures::AxisFacts> Axes() const;

  Context context_;
  procedures::ProcedureLibrary library_;
  std::mutex start_mutex_;
  std::thread thread_;
  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<RunExecution> last_;
};

}  // namespace gyrobench::daemon
