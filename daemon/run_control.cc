#include "daemon/run_control.h"

#include <algorithm>

#include "procedures/engine/engine.h"

namespace gyrobench::daemon {

bool RunControl::MoveLocked(Event event) {
  const std::optional<State> next = Next(state_, event);
  if (next) state_ = *next;
  return next.has_value();
}

void RunControl::MoveIfFitsLocked(Event event) { (void)MoveLocked(event); }

void RunControl::MoveOfRunLocked(Event event) {
  ThrowIfToEndLocked();
  if (MoveLocked(event)) return;
  throw StateError(std::string("the run cannot go on: no '") + Name(event) + "' in the state " +
                   Name(state_));
}

void RunControl::RequireLocked(Event event) {
  if (MoveLocked(event)) return;
  throw StateError(std::string("no run to do this with: the bench is ") + Name(state_));
}

void RunControl::GoOnLocked(Event event) {
  MoveIfFitsLocked(event);
  if (silent_ && !holding_) MoveIfFitsLocked(Event::kSilence);
  if (pause_) MoveIfFitsLocked(Event::kPause);
}

void RunControl::Wake() {
  if (waiter_ != nullptr) waiter_->Notify();
}

void RunControl::Pause() {
  const std::lock_guard lock(mutex_);
  RequireLocked(Event::kPause);
  pause_ = true;
  Wake();
}

void RunControl::Resume() {
  const std::lock_guard lock(mutex_);
  if (waiter_ != nullptr && !pause_) throw StateError("the run is not paused");
  if (waiter_ == nullptr) {
    throw StateError(std::string("no run is paused: the bench is ") + Name(state_) +
                     ". One that was interrupted is taken up with: gyrobench resume latest");
  }
  RequireLocked(Event::kResume);
  pause_ = false;
  Wake();
}

void RunControl::Abort(const std::string& reason) {
  const std::lock_guard lock(mutex_);
  RequireLocked(Event::kAbort);
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
  RequireLocked(Event::kStop);
  if (waiter_ == nullptr) return;
  if (!abort_) abort_ = reason;
  Wake();
}

std::int64_t RunControl::stops() const {
  const std::lock_guard lock(mutex_);
  return stops_;
}

void RunControl::Answer(const std::string& answer) {
  const std::lock_guard lock(mutex_);
  if (state_ != State::kAsking) {
    throw StateError(std::string("the run has asked nothing: the bench is ") + Name(state_));
  }
  const auto& choices = question_->choices;
  if (!choices.empty() && std::find(choices.begin(), choices.end(), answer) == choices.end()) {
    std::string known;
    for (const std::string& choice : choices) known += (known.empty() ? "" : ", ") + choice;
    throw StateError("'" + answer + "' is no answer to this question; choose one of: " + known);
  }
  answer_ = answer;
  GoOnLocked(Event::kAnswer);
  Wake();
}

void RunControl::ClearFault() {
  const std::lock_guard lock(mutex_);
  if (!MoveLocked(Event::kReset)) throw StateError("a run is on; abort it first");
  fault_.reset();
  if (!all_well_) MoveIfFitsLocked(Event::kDeviceLost);
}

bool RunControl::Report(const Fault& fault) {
  const std::lock_guard lock(mutex_);
  MoveIfFitsLocked(Event::kTrip);
  if (fault_) {
    const bool same = fault_->source == fault.source && fault_->message == fault.message;
    if (same && !fault_->place) fault_->place = fault.place;
    return !same;
  }
  fault_ = fault;
  Wake();
  return true;
}

bool RunControl::Suspend(const Fault& silent) {
  const std::lock_guard lock(mutex_);
  if (!MoveLocked(Event::kSilence)) return false;
  ++silences_;
  if (!silent_ || holding_) silent_ = silent;
  Wake();
  return true;
}

void RunControl::SetAllWell(bool all_well) {
  const std::lock_guard lock(mutex_);
  all_well_ = all_well;
  MoveIfFitsLocked(all_well ? Event::kAllWell : Event::kDeviceLost);
}

void RunControl::SetLeft(const std::vector<std::string>& left) {
  const std::lock_guard lock(mutex_);
  if (fault_) fault_->left = left;
}

State RunControl::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
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
    throw StateError("a fault is latched (" + TextOf(*fault_) +
                     "). When its cause is removed: gyrobench reset");
  }
  if (waiter_ != nullptr) throw StateError("a run is on already; see: gyrobench status");
}

void RunControl::BeginRun(Clock::Participant& waiter, std::optional<std::int64_t> stops,
                          Devices devices) {
  const std::lock_guard lock(mutex_);
  RequireReadyLocked();
  if (stops && *stops != stops_) {
    throw StateError("stopped before the run began: nothing has moved");
  }
  if (!MoveLocked(devices == Devices::kMustBeWell ? Event::kBegin : Event::kCommission)) {
    throw StateError("a device is not well, so nothing was started; see: gyrobench status");
  }
  waiter_ = &waiter;
  abort_.reset();
  tidying_ = pause_ = holding_ = false;
  answer_.reset();
  silent_.reset();
}

void RunControl::Prepared() {
  const std::lock_guard lock(mutex_);
  GoOnLocked(Event::kPrepared);
}

void RunControl::EndRun() {
  const std::lock_guard lock(mutex_);
  waiter_ = nullptr;
  question_.reset();
  MoveIfFitsLocked(Event::kFinish);
  MoveIfFitsLocked(fault_ ? Event::kFailed : Event::kEnded);
  if (!all_well_) MoveIfFitsLocked(Event::kDeviceLost);
}

void RunControl::ThrowIfToEndLocked() const {
  if (tidying_) return;
  if (fault_) throw FaultError(*fault_);
  if (abort_) throw procedures::Aborted(*abort_);
}

void RunControl::ThrowIfToEnd() const {
  const std::lock_guard lock(mutex_);
  ThrowIfToEndLocked();
  if (!tidying_ && silent_ && !holding_) throw Suspended(*silent_);
}

bool RunControl::IsToEnd() const {
  const std::lock_guard lock(mutex_);
  return !tidying_ && (fault_ || abort_);
}

void RunControl::Wait(const Clock& clock, Utime wake_up) {
  do {
    ThrowIfToEnd();
  } while (waiter_->WaitUntil(wake_up) && clock.Now() < wake_up);
  ThrowIfToEnd();
}

std::optional<Fault> RunControl::suspended() const {
  const std::lock_guard lock(mutex_);
  return silent_;
}

int RunControl::silences() const {
  const std::lock_guard lock(mutex_);
  return silences_;
}

void RunControl::BeginHold() {
  const std::lock_guard lock(mutex_);
  holding_ = true;
}

bool RunControl::EndHold(int silences) {
  const std::lock_guard lock(mutex_);
  if (silences != silences_) return false;
  silent_.reset();
  GoOnLocked(Event::kBack);
  holding_ = false;
  return true;
}

void RunControl::WaitWhilePaused(const std::function<Utime()>& look) {
  const auto is_wanted = [this] {
    const std::lock_guard lock(mutex_);
    ThrowIfToEndLocked();
    if (pause_) MoveOfRunLocked(Event::kSafePoint);
    return pause_;
  };
  while (is_wanted()) waiter_->WaitUntil(look());
  const std::lock_guard lock(mutex_);
  if (silent_) MoveIfFitsLocked(Event::kSilence);
}

std::optional<std::string> RunControl::WaitForAnswer(const Clock& clock,
                                                     const procedures::Question& question,
                                                     Utime deadline) {
  const auto take_answer = [this] {
    const std::lock_guard lock(mutex_);
    ThrowIfToEndLocked();
    return answer_;
  };
  {
    const std::lock_guard lock(mutex_);
    MoveOfRunLocked(Event::kAsk);
    question_ = question;
    answer_.reset();
  }
  while (!take_answer() && clock.Now() < deadline) waiter_->WaitUntil(deadline);
  const std::lock_guard lock(mutex_);
  question_.reset();
  std::optional<std::string> answer = answer_;
  if (!answer) GoOnLocked(Event::kAnswer);
  return answer;
}

void RunControl::BeginStopping() {
  const std::lock_guard lock(mutex_);
  tidying_ = true;
  MoveIfFitsLocked(Event::kFinish);
}

}  // namespace gyrobench::daemon
