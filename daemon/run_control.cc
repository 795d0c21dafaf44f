#include "daemon/run_control.h"

#include <algorithm>

#include "procedures/engine/engine.h"

namespace gyrobench::daemon {

const char* Name(State state) {
  switch (state) {
    case State::kIdle:
      return "idle";
    case State::kRunning:
      return "running";
    case State::kPaused:
      return "paused";
    case State::kAsking:
      return "asking";
    case State::kStopping:
      return "stopping";
    case State::kFault:
      return "fault";
    case State::kPausing:
      return "pausing";
  }
  return "unknown";
}

void RunControl::RequireRun() const {
  if (waiter_ == nullptr || state_ == State::kStopping) {
    throw StateError(std::string("no run to do this with: the bench is ") + Name(state_));
  }
}

void RunControl::Wake() {
  if (waiter_ != nullptr) waiter_->Notify();
}

void RunControl::Pause() {
  const std::lock_guard lock(mutex_);
  RequireRun();
  pause_ = true;
  Wake();
}

void RunControl::Resume() {
  const std::lock_guard lock(mutex_);
  RequireRun();
  if (!pause_) throw StateError("the run is not paused");
  pause_ = false;
  Wake();
}

void RunControl::Abort(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  RequireRun();
  if (!abort_) abort_ = reason;
  Wake();
}

void RunControl::Stop(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  StopLocked(reason);
}

void RunControl::StopForGood(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  stopped_for_good_ = true;
  StopLocked(reason);
}

bool RunControl::stopped_for_good() const {
  const std::lock_guard lock(mutex_);
  return stopped_for_good_;
}

void RunControl::StopLocked(const std::string& reason) {
  ++stops_;
  if (waiter_ == nullptr || state_ == State::kStopping) return;
  if (!abort_) abort_ = reason;
  Wake();
}

std::int64_t RunControl::stops() const {
  const std::lock_guard lock(mutex_);
  return stops_;
}

void RunControl::Answer(const std::string& answer) {
  const std::lock_guard lock(mutex_);
  RequireRun();
  if (!question_) throw StateError("the run has asked nothing");
  const auto& choices = question_->choices;
  if (!choices.empty() && std::find(choices.begin(), choices.end(), answer) == choices.end()) {
    std::string known;
    for (const std::string& choice : choices) known += (known.empty() ? "" : ", ") + choice;
    throw StateError("'" + answer + "' is no answer to this question; choose one of: " + known);
  }
  answer_ = answer;
  Wake();
}

void RunControl::ClearFault() {
  const std::lock_guard lock(mutex_);
  if (waiter_ != nullptr) throw StateError("a run is on; abort it first");
  fault_.reset();
  state_ = State::kIdle;
}

void RunControl::Report(const Fault& fault) {
  const std::lock_guard lock(mutex_);
  if (fault_) {
    const bool same = fault_->source == fault.source && fault_->message == fault.message;
    if (same && !fault_->place) fault_->place = fault.place;
    return;
  }
  fault_ = fault;
  if (waiter_ == nullptr) state_ = State::kFault;
  Wake();
}

State RunControl::state() const {
  const std::lock_guard lock(mutex_);
  if (waiter_ != nullptr && abort_) return State::kStopping;
  const bool goes_on =
      (state_ == State::kPaused && !pause_) || (state_ == State::kAsking && answer_);
  const State state = goes_on ? State::kRunning : state_;
  return state == State::kRunning && pause_ ? State::kPausing : state;
}

std::optional<Fault> RunControl::fault() const {
  const std::lock_guard lock(mutex_);
  return fault_;
}

std::optional<procedures::Question> RunControl::question() const {
  const std::lock_guard lock(mutex_);
  return question_;
}

bool RunControl::pause_wanted() const {
  const std::lock_guard lock(mutex_);
  return pause_;
}

bool RunControl::run_is_on() const {
  const std::lock_guard lock(mutex_);
  return waiter_ != nullptr;
}

void RunControl::RequireReady() const {
  const std::lock_guard lock(mutex_);
  RequireReadyLocked();
}

void RunControl::RequireReadyLocked() const {
  if (stopped_for_good_) throw StateError("the daemon is ending: no run begins any more");
  if (fault_) {
    throw StateError("a fault is latched (" + fault_->source + ": " + fault_->message +
                     "). When its cause is removed: gyrobench reset");
  }
  if (waiter_ != nullptr) throw StateError("a run is on already; see: gyrobench status");
}

void RunControl::BeginRun(Clock::Participant& waiter, std::optional<std::int64_t> stops) {
  const std::lock_guard lock(mutex_);
  RequireReadyLocked();
  if (stops && *stops != stops_) {
    throw StateError("stopped before the run began: nothing has moved");
  }
  waiter_ = &waiter;
  abort_.reset();
  pause_ = false;
  answer_.reset();
  state_ = State::kRunning;
}

void RunControl::EndRun() {
  const std::lock_guard lock(mutex_);
  waiter_ = nullptr;
  question_.reset();
  state_ = fault_ ? State::kFault : State::kIdle;
}

void RunControl::ThrowIfToEnd() const {
  const std::lock_guard lock(mutex_);
  if (state_ == State::kStopping) return;
  if (fault_) throw FaultError(*fault_);
  if (abort_) throw procedures::Aborted(*abort_);
}

bool RunControl::IsToEnd() const {
  const std::lock_guard lock(mutex_);
  return state_ != State::kStopping && (fault_ || abort_);
}

void RunControl::Wait(const Clock& clock, Utime wake_up) {
  do {
    ThrowIfToEnd();
  } while (waiter_->WaitUntil(wake_up) && clock.Now() < wake_up);
  ThrowIfToEnd();
}

void RunControl::WaitWhilePaused() {
  const auto set_state = [this](State state) {
    const std::lock_guard lock(mutex_);
    state_ = state;
  };
  set_state(State::kPaused);
  while (pause_wanted()) {
    ThrowIfToEnd();
    waiter_->WaitUntil(kForever);
  }
  set_state(State::kRunning);
  ThrowIfToEnd();
}

std::optional<std::string> RunControl::WaitForAnswer(const Clock& clock,
                                                     const procedures::Question& question,
                                                     Utime deadline) {
  {
    const std::lock_guard lock(mutex_);
    question_ = question;
    answer_.reset();
    state_ = State::kAsking;
  }
  std::optional<std::string> answer;
  while (!answer && clock.Now() < deadline) {
    ThrowIfToEnd();
    waiter_->WaitUntil(deadline);
    const std::lock_guard lock(mutex_);
    answer = answer_;
  }
  const std::lock_guard lock(mutex_);
  question_.reset();
  state_ = State::kRunning;
  return answer;
}

void RunControl::BeginStopping() {
  const std::lock_guard lock(mutex_);
  state_ = State::kStopping;
}

}  // namespace gyrobench::daemon
