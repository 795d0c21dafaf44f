// What an operator, a fault and a run say to each other.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "daemon/fault.h"
#include "daemon/stand_state.h"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

// A request that does not fit the state (HTTP 409).
class StateError : public Error {
 public:
  using Error::Error;
};

// A device fell silent, and the command under way is to be made again when it is back.
class Suspended : public Error {
 public:
  explicit Suspended(Fault fault) : Error(TextOf(fault)), fault_(std::move(fault)) {}
  const Fault& fault() const { return fault_; }

 private:
  Fault fault_;
};

// The state of the stand, moved by the table of stand_state.h alone. Thread-safe. The run's thread
// waits here and nowhere else, so that it hears of abort and fault at once.
class RunControl {
 public:
  // --- for operators and supervisors; StateError when it does not fit the state
  void Pause();
  void Resume();
  // `reason`: how the run is said to have ended. The first one counts.
  void Abort(const std::string& reason = "aborted by the operator");
  // In every state: a run that is on is aborted, and one that was asked for before and is not on
  // yet does not begin.
  void Stop(const std::string& reason);
  // The same for good: no run begins any more.
  void StopForGood(const std::string& reason);
  bool stopped_for_good() const;
  // How often either was called.
  std::int64_t stops() const;
  void Answer(const std::string& answer);
  void ClearFault();
  // Latches the first fault and ends a run that is on. Where the same is reported again, the place
  // in the script is taken over if none was known; false then.
  bool Report(const Fault& fault);
  // A device that is needed fell silent. False where no run can wait for it: a fault, then.
  bool Suspend(const Fault& silent);
  // Whether all devices are well.
  void SetAllWell(bool all_well);
  // What became of the stand after the fault that is latched.
  void SetLeft(const std::vector<std::string>& left);

  // With what was commanded last, even while the run's thread has yet to notice.
  State state() const;
  std::optional<Fault> fault() const;
  std::optional<procedures::Question> question() const;
  bool pause_wanted() const;
  bool run_is_on() const;

  // Throws StateError, which says what to do, when no run can be begun: one is on, a fault is
  // latched, or it was stopped for good.
  void RequireReady() const;

  // --- for the run
  // From kIdle to kPreparing; of a run that commissions the stand from kDisconnected as well.
  // `waiter` is the run's participant, until EndRun. `stops`: as it was when the run was asked for;
  // StateError where Stop was called since.
  enum class Devices { kMustBeWell, kMayBeUnwell };
  void BeginRun(Clock::Participant& waiter, std::optional<std::int64_t> stops = std::nullopt,
                Devices devices = Devices::kMustBeWell);
  // The procedure begins.
  void Prepared();
  void EndRun();
  // Waits until `wake_up`. Throws procedures::Aborted, FaultError or Suspended as soon as there is
  // reason.
  void Wait(const Clock& clock, Utime wake_up);
  void ThrowIfToEnd() const;
  // Whether it would throw.
  bool IsToEnd() const;
  // Why the run is suspended. From BeginHold to EndHold the run's thread waits for the device, and
  // nothing throws Suspended. In a hold, the one that fell silent last.
  std::optional<Fault> suspended() const;
  // How often a device that the run can wait for fell silent, since the daemon began.
  int silences() const;
  void BeginHold();
  // `silences`: when all devices were found well. False, and the hold goes on, where one fell silent
  // since: it is told only once.
  bool EndHold(int silences);
  // While the operator wants a pause: state kPaused, and waits. `look`: asked whenever something
  // was told, and when it said last; what it throws ends the wait.
  void WaitWhilePaused(const std::function<Utime()>& look = [] { return kForever; });
  // State kAsking until an answer came or `deadline`; nullopt: nobody answered.
  std::optional<std::string> WaitForAnswer(const Clock& clock, const procedures::Question& question,
                                           Utime deadline);
  // From here on the run only tidies up: Wait waits, and throws no more.
  void BeginStopping();

 private:
  void RequireReadyLocked() const;
  // False where the event does not fit the state.
  [[nodiscard]] bool MoveLocked(Event event);
  // Where it does not, it passes by.
  void MoveIfFitsLocked(Event event);
  // What a run that goes on does itself. StateError where the table does not know it: a run that
  // waited in a state that cannot go on would wait for ever.
  void MoveOfRunLocked(Event event);
  // StateError where it does not.
  void RequireLocked(Event event);
  // A run goes on; a pause that was asked for meanwhile comes next.
  void GoOnLocked(Event event);
  void ThrowIfToEndLocked() const;
  void StopLocked(const std::string& reason);
  void Wake();

  mutable std::mutex mutex_;
  State state_ = State::kIdle;
  Clock::Participant* waiter_ = nullptr;
  std::optional<std::string> abort_;  // why
  std::int64_t stops_ = 0;
  bool stopped_for_good_ = false;
  bool tidying_ = false;  // the run's thread has heard that the run is to end
  bool pause_ = false;
  bool all_well_ = true;
  std::optional<Fault> silent_;  // the run is suspended, or is to be
  int silences_ = 0;
  bool holding_ = false;
  std::optional<Fault> fault_;
  std::optional<procedures::Question> question_;
  std::optional<std::string> answer_;
};

}  // namespace gyrobench::daemon
