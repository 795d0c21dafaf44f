// The bench that moves: what a procedure's commands do on the stand.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/clock.h"
#include "calibration/estimators/results.h"
#include "calibration/plan/next_manoeuvre.h"
#include "calibration/trace/trace.h"
#include "commission/wiring.h"
#include "config/stand_config.h"
#include "daemon/acquisition.h"
#include "daemon/progress_meter.h"
#include "daemon/run_control.h"
#include "daemon/segment_analysis.h"
#include "daemon/suspension.h"
#include "daemon/telemetry.h"
#include "gyrobench/run_t.hpp"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

struct FinishedCommand;
struct ResumedRun;

// Progress of a run, for status and messages.
struct RunProgress {
  std::string segment;
  int segments_done = 0;
  double fraction = 0.0;
  double remaining_s = kMissing;
  std::string message;
};

// Serves one run, in the run's thread. Every wait hears of abort and fault; a move that is cut
// short leaves the stand stopping (the run engine waits for it). A command in which a device falls
// silent is begun again (Suspension).
class LiveBench final : public procedures::Bench {
 public:
  struct Context {
    const config::StandConfig& stand;
    Clock& clock;
    Clock::Participant& participant;
    Acquisition& acquisition;
    Telemetry& telemetry;
    RunControl& control;
    double planned_duration_s;
    // The stand file answered in the operator's place.
    std::function<void(const std::string& question_id)> on_configured_answer;
    // Lets virtual time run at its idle pace while a person is asked (true) and back (false).
    // Returns whether bench time stands still now, so that no deadline ever comes.
    std::function<bool(bool asking)> set_asking_pace;
    std::function<void(const RunProgress&)> on_progress;
    bool commissions = false;  // the procedure is for a stand whose file may be wrong
  };
  // `start`: utime of the run's begin.
  LiveBench(Context context, Utime start);

  double ElapsedS() const override;
  std::vector<procedures::AxisFacts> Axes() const override;
  StandGeometry Geometry() const override;
  double TemperatureDegC() const override;
  std::vector<std::string> Outputs() const override;
  void SwitchOutput(const std::string& output, bool on) override;
  procedures::TurnOutcome Turn(const procedures::TurnCommand& command) override;
  procedures::SwingOutcome Swing(const procedures::SwingCommand& command) override;
  void Rest(double duration_s) override;
  procedures::SoakOutcome Soak(const procedures::SoakCommand& command) override;
  std::string Ask(const procedures::Question& question) override;
  procedures::Estimate ReadEstimate(const std::string& what) override;
  std::vector<procedures::AxisVerdict> Trace() override;
  procedures::Choice Choose(const std::vector<procedures::Rehearsal>& menu,
                            double small_below) override;
  procedures::WiringReport FindWiring() override;
  std::string WriteStandFile() override;
  void RecordLimit(const procedures::LimitCheck& check) override;
  void Say(const std::string& text) override;
  void Progress(double fraction) override;
  void SafePoint() override;

  // A command is over (JournalBench): for whoever takes up this run, should its daemon end with it.
  void Record(const FinishedCommand& command);
  // Goes on with what another run had begun: turns the axes to where the first command that was not
  // over began, and measures from there.
  void TakeUp(const ResumedRun& run);
  // Waits until no result of a segment is worked out any more.
  void FinishResults() { analysis_.Finish(context_.participant); }
  // As it was found out.
  const std::optional<commission::Wiring>& wiring() const { return wiring_; }
  // Measurements against limits that the procedure made.
  const std::vector<procedures::LimitCheck>& limits() const { return limits_; }
  // What the operator was asked to switch on, and not to switch off yet.
  const std::set<std::string>& on_by_hand() const { return on_by_hand_; }
  // What the procedure said, limits among it; the first 10 000.
  struct Said {
    double t_s = 0.0;  // since the run began
    std::string text;
  };
  const std::vector<Said>& said() const { return said_; }
  // The run waited for devices that were silent, and went back; those that ended it are no part.
  struct Suspensions {
    int count = 0;
    double duration_s = 0.0;
    std::set<std::string> devices;
  };
  const Suspensions& suspensions() const { return suspensions_; }

 private:
  // A command. Where a device falls silent meanwhile, or fell silent before, it is begun (again) once
  // the device is back. A command that fails otherwise is not begun again.
  void Resumably(const std::function<void()>& command);
  // In a handler: throws it on where the run cannot wait for the device.
  void SuspendOrRethrow(const DeviceError& error, bool may_wait);
  void Interrupt(const Fault& silent);
  // The last moment at which nothing was silent is now. Throws Suspended where it is not.
  void KeepPoint();
  void PauseIfWanted();
  procedures::TurnOutcome TurnOnce(const procedures::TurnCommand& command);
  procedures::SwingOutcome SwingOnce(const procedures::SwingCommand& command);
  void RestOnce(double duration_s);
  procedures::SoakOutcome SoakOnce(const procedures::SoakCommand& command);
  void BeginSegment(const std::string& kind, const std::string& name);
  // With a message and results, once the gyro's samples of the segment have come.
  void EndSegment();
  // Waits for all but the newest of `kSwingOut_s`. Throws Suspended where the gyro fell silent, and
  // what else ends a wait of a run.
  void AwaitSamples();
  void UpdateTime();
  // Time since `begin_s` that no plan knows of.
  void AddWaiting(double begin_s);
  // Starts a move; returns the rate that the drive uses.
  double StartMove(const procedures::TurnCommand& command);
  // The drive is asked every `poll` once the time is over that the move should take.
  AxisView WaitForEndOfMove(const std::string& axis, double expected_s, Utime poll);
  void CheckFollowing(const procedures::TurnCommand& command, double moved_deg);
  run_t Message(std::int8_t event) const;

  Context context_;
  Suspension suspension_;
  Suspension::Point last_good_;  // at the end of the last command; between commands nothing moves
  std::set<std::string> switched_on_;  // by the procedure
  const Utime start_;
  RunProgress progress_;
  ProgressMeter meter_;
  double planned_s_;  // duration of the run as it looks now
  std::set<std::string> on_by_hand_;
  double waited_s_ = 0.0;  // of it, spent on questions and pauses
  std::string segment_kind_;
  Utime segment_begin_ = 0;
  std::optional<calibration::Traced> traced_;  // nothing moved since
  calibration::LoopMemory loop_;
  std::vector<procedures::LimitCheck> limits_;
  std::vector<Said> said_;
  Suspensions suspensions_;
  std::optional<commission::Wiring> wiring_;
  SegmentAnalysis analysis_;  // last: it is at work until it is gone
};

}  // namespace gyrobench::daemon
