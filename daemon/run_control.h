// What an operator, a fault and a run say to each other.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "base/clock.h"
#include "base/error.h"
#include "daemon/fault.h"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {

// kPausing: the operator wants a pause, and the segment under way ends first.
enum class State { kIdle, kRunning, kPaused, kAsking, kStopping, kFault, kPausing };
const char* Name(State state);

// A request that does not fit the state (HTTP 409).
class StateError : public Error {
 public:
  using Error::Error;
};

// Thread-safe. The run's thread waits here and nowhere else, so that it hears of abort and fault at
// once.
class RunControl {
 public:
  // --- for operators and supervisors; StateError when it does not fit the state
  void Pause();
  void Resume();
  // `reason`: how the run is said to have ended.
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
  // in the script is taken over if none was known.
  void Report(const Fault& fault);

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
  // From kIdle to kRunning. `waiter` is the run's participant, until EndRun. `stops`: as it was
  // when the run was asked for; StateError where Stop was called since.
  void BeginRun(Clock::Participant& waiter, std::optional<std::int64_t> stops = std::nullopt);
  void EndRun();
  // Waits until `wake_up`. Throws procedures::Aborted or FaultError as soon as there is reason.
  void Wait(const Clock& clock, Utime wake_up);
  void ThrowIfToEnd() const;
  // Whether it would throw.
  bool IsToEnd() const;
  // While the operator wants a pause: state kPaused, and waits.
  void WaitWhilePaused();
  // State kAsking until an answer came or `deadline`; nullopt: nobody answered.
  std::optional<std::string> WaitForAnswer(const Clock& clock, const procedures::Question& question,
                                           Utime deadline);
  // From here on the run only tidies up: Wait waits, and throws no more.
  void BeginStopping();

 private:
  void RequireReadyLocked() const;
  void RequireRun() const;
  void StopLocked(const std::string& reason);
  void Wake();

  mutable std::mutex mutex_;
  State state_ = State::kIdle;
  Clock::Participant* waiter_ = nullptr;
  std::optional<std::string> abort_;  // why
  std::int64_t stops_ = 0;
  bool stopped_for_good_ = false;
  bool pause_ = false;
  std::optional<Fault> fault_;
  std::optional<procedures::Question> question_;
  std::optional<std::string> answer_;
};

}  // namespace gyrobench::daemon
