// Runs: from a procedure's name to a closed record.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/bench_time.h"
#include "daemon/live_bench.h"
#include "daemon/run_control.h"
#include "daemon/telemetry.h"
#include "procedures/engine/dry_bench.h"
#include "procedures/engine/procedure.h"

namespace gyrobench::daemon {

// How a run ended. kFailedLimits is a run that went well on a part that did not.
enum class Outcome { kNone, kDone, kFailedLimits, kAborted, kFault, kError };
const char* Name(Outcome outcome);

// The last or present run, for status.
struct RunView {
  std::string run_id;
  std::string procedure;
  procedures::Parameters parameters;
  std::string record;
  Outcome outcome = Outcome::kNone;
  RunProgress progress;
  double elapsed_s = 0.0;
  std::vector<Fault> failures;  // that it ended by, in their order
};

struct StartedRun {
  std::string run_id;
  std::string record;
  double duration_s = 0.0;  // planned
};

// One run at a time, each in a thread of its own. Thread-safe.
class RunEngine {
 public:
  struct Context {
    const config::StandConfig& stand;
    Clock& clock;
    Acquisition& acquisition;
    Telemetry& telemetry;
    RunControl& control;
    BenchTime& time;
    std::function<void()> on_change;  // of the state
    FaultHandler on_fault;            // latches and publishes it
    std::function<void()> on_fault_cleared;
    std::function<void(const std::string& question_id)> on_configured_answer;
  };
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
  struct Job;
  struct Ending {
    Outcome outcome = Outcome::kDone;
    std::string message;          // why, where it is not kDone
    std::vector<Fault> failures;  // the same as fields, where something failed
  };
  void Execute(Job& job);
  Ending RunToItsEnd(Job& job);
  void RunProcedureOn(Job& job);
  void WaitForTickFit(const Job& job);
  // From here on the run has an event log. Before its first motion, or at its end when it came to
  // none.
  void BeginRecord(Job& job, Utime start);
  void WaitForStandstill(Job& job, const std::string& axis);
  void StopMotion(Job& job, Ending& ending);
  void SwitchOff(Job& job, Ending& ending);
  // A fault on the way to the end: told, latched, and added to how the run ended.
  void AddFault(Ending& ending, Fault fault);
  // Closes the record. Results that cannot be make an error of a run that was done.
  void Finish(Job& job, Ending& ending);
  static procedures::RunHooks DryHooks();
  procedures::DryOptions DryOptions() const;
  void RequireDevicesWell() const;
  std::vector<procedures::AxisFacts> Axes() const;

  Context context_;
  procedures::ProcedureLibrary library_;
  std::mutex start_mutex_;
  std::thread thread_;
  mutable std::mutex mutex_;  // guards view_
  std::optional<RunView> view_;
  Utime run_start_ = 0;
};

}  // namespace gyrobench::daemon
