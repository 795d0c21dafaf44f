// The states of the stand, and what leads from one to another: one table, which docs/reliability.md
// shows.
#pragma once

#include <optional>
#include <span>

namespace gyrobench::daemon {

// As status_t numbers them.
enum class State {
  kIdle,
  kRunning,
  kPaused,
  kAsking,
  kStopping,      // the run is to end: axes are stopped, outputs switched off, the record is closed
  kFault,         // latched: nothing moves until a reset
  kPausing,       // the operator wants a pause, and the segment under way ends first
  kDisconnected,  // no run, and a device does not answer or is not what it should be
  kPreparing,     // a run has begun, and its procedure has not
  kSuspended,     // a device fell silent in a run: axes stopped, waiting for it
};
inline constexpr int kStates = 10;
const char* Name(State state);

enum class Event {
  kDeviceLost,  // a device is not well
  kAllWell,     // all devices are
  kBegin,       // a run
  kCommission,  // one that finds out how a stand is wired, with devices that may not be well
  kPrepared,    // its procedure begins
  kAsk,         // the operator
  kAnswer,      // or nobody answered in time
  kPause,
  kResume,
  kSafePoint,  // where a run may pause
  kSilence,    // a device that a run needs fell silent
  kBack,       // it is back, and the same
  kStop,       // in every state; ends a run
  kAbort,      // ends a run
  kTrip,       // a fault
  kFinish,     // the procedure is over, however it ended
  kEnded,      // the record is closed
  kFailed,     // the record is closed, and a fault is latched
  kReset,
};
inline constexpr int kEvents = 19;
const char* Name(Event event);

struct Transition {
  State from;
  Event event;
  State to;
};
std::span<const Transition> Transitions();
// nullopt: the event does not fit the state. What an operator asks for is refused then.
std::optional<State> Next(State from, Event event);

}  // namespace gyrobench::daemon
