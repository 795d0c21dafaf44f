// Runs: from a procedure's name to a closed record.
#pragma once

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
  // DeviceError while a device is not well. Nothing has moved then.
  StartedRun Start(const std::string& procedure, const procedures::Parameters& parameters);
  // Clears a latched fault and the drives' alarms. Throws StateError while a run is on.
  void Reset();
  // Ends a run that is on, and waits for it.
  void Shutdown();
  std::optional<RunView> View() const;

 private:
  static procedures::RunHooks DryHooks();
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
