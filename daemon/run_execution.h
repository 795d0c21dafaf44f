// One run in its thread: its procedure, its record, its end.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.h"
#include "calibration/estimators/results.h"
#include "calibration/trace/trace.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/bench_time.h"
#include "daemon/live_bench.h"
#include "daemon/resumed_run.h"
#include "daemon/run_control.h"
#include "daemon/telemetry.h"
#include "procedures/engine/dry_bench.h"
#include "procedures/engine/procedure.h"
#include "recording/run_directory.h"

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

// What runs need of the daemon. All outlives them.
struct RunContext {
  const config::StandConfig& stand;
  Clock& clock;
  Acquisition& acquisition;
  Telemetry& telemetry;
  RunControl& control;
  BenchTime& time;
  std::function<void()> on_change;    // of the state
  FaultHandler on_fault;              // latches and publishes it
  std::function<void()> clear_fault;  // the same back; StateError while a run is on
  std::function<void(const std::string& question_id)> on_configured_answer;
};

// Throws DeviceError, with its fields, for the first device that is not well.
void RequireDevicesWell(const Acquisition& acquisition);
// The same for one that gives no reply at all.
void RequireDevicesAnswer(const Acquisition& acquisition);

class RunExecution {
 public:
  // `participant`: whom the run waits as. What RunControl::BeginRun was told. `resumed`: the run
  // that it takes up.
  RunExecution(const RunContext& context, procedures::Procedure procedure,
               procedures::Parameters parameters, procedures::Plan plan,
               recording::RunDirectory directory, std::unique_ptr<Clock::Participant> participant,
               std::optional<ResumedRun> resumed = {});

  // From the comparison of clocks to the closed record; whatever happens, the stand is at rest and
  // the outputs are off then. Does not throw. In the run's thread, once.
  void Execute();
  // From any thread.
  RunView View() const;

 private:
  struct Ending {
    Outcome outcome = Outcome::kDone;
    std::string message;          // why, where it is not kDone
    std::vector<Fault> failures;  // the same as fields, where something failed

    bool came_to_its_end() const {
      return outcome == Outcome::kDone || outcome == Outcome::kFailedLimits;
    }
    // One more thing to say of it.
    void Say(const std::string& text) { message += (message.empty() ? "" : "; ") + text; }
  };
  Ending RunToItsEnd();
  void RunProcedure();
  void MakeBench(Utime start);
  // On the live bench, or by its journal where the procedure can be taken up.
  void RunScript();
  void WaitForTickFit();
  // Until the clock has passed the end of the run that is taken up.
  void WaitForEarlierEnd();
  // From here on the run has an event log. Before its first motion, or at its end when it came to
  // none.
  void BeginRecord(Utime start);
  // Now, or that of the run that is taken up.
  Utime BeginOfMeasurement() const;
  void WaitForStandstill(const std::string& axis);
  void StopMotion(Ending& ending);
  void SwitchOff(Ending& ending);
  // A fault on the way to the end: told, latched, and added to how the run ended.
  void AddFault(Ending& ending, Fault fault);
  struct Results {
    calibration::AnalysisResult analysis;
    std::optional<calibration::Traced> trace;  // of a run that came to its end
  };
  // A part of the end that the others do not depend on: what it throws is a fault of the record.
  void Attempt(Ending& ending, const std::function<void()>& part);
  // Closes the record: each part of it is tried, whatever becomes of the others, and how the run
  // ended is told last.
  void Finish(Ending& ending);
  void TellOfSuspensions(Ending& ending) const;
  void TellOfGyro(Ending& ending);
  // Results that cannot be make an error of a run that was done.
  Results Evaluate(Ending& ending, Utime end);
  void WriteFiles(Ending& ending, const Results& results, Utime end);
  // Shows how the run ended and makes room for the next one as one step: whoever sees the end may
  // start a run at once.
  void End(const Ending& ending);

  const RunContext& context_;
  const procedures::Procedure procedure_;
  const procedures::Parameters parameters_;
  const procedures::Plan plan_;
  const recording::RunDirectory directory_;
  std::unique_ptr<Clock::Participant> participant_;
  const std::optional<ResumedRun> resumed_;
  nlohmann::json description_;
  std::string power_on_at_begin_;
  // Of the gyro when the measurement began.
  std::int64_t missed_before_ = std::numeric_limits<std::int64_t>::max();
  int starts_before_ = std::numeric_limits<int>::max();
  std::unique_ptr<LiveBench> bench_;
  mutable std::mutex mutex_;  // guards what follows
  RunView view_;
  Utime start_;
};

}  // namespace gyrobench::daemon
