#include "daemon/stand_state.h"

#include <algorithm>
#include <array>

namespace gyrobench::daemon {
namespace {

using enum State;

constexpr Transition kTransitions[] = {
    // Without a run.
    {kIdle, Event::kDeviceLost, kDisconnected},
    {kDisconnected, Event::kAllWell, kIdle},
    {kIdle, Event::kBegin, kPreparing},
    {kIdle, Event::kCommission, kPreparing},
    {kDisconnected, Event::kCommission, kPreparing},
    {kIdle, Event::kStop, kIdle},
    {kDisconnected, Event::kStop, kDisconnected},
    {kFault, Event::kStop, kFault},
    {kIdle, Event::kTrip, kFault},
    {kDisconnected, Event::kTrip, kFault},
    {kFault, Event::kTrip, kFault},
    {kIdle, Event::kReset, kIdle},
    {kDisconnected, Event::kReset, kDisconnected},
    {kFault, Event::kReset, kIdle},
    // The course of a run.
    {kPreparing, Event::kPrepared, kRunning},
    {kRunning, Event::kAsk, kAsking},
    {kPausing, Event::kAsk, kAsking},
    {kSuspended, Event::kAsk, kAsking},
    {kAsking, Event::kAnswer, kRunning},
    {kPausing, Event::kSafePoint, kPaused},
    {kSuspended, Event::kSafePoint, kPaused},
    {kPaused, Event::kSafePoint, kPaused},
    // A pause that is asked for where there is none to be made is made as soon as there is.
    {kPreparing, Event::kPause, kPreparing},
    {kRunning, Event::kPause, kPausing},
    {kPausing, Event::kPause, kPausing},
    {kPaused, Event::kPause, kPaused},
    {kAsking, Event::kPause, kAsking},
    {kSuspended, Event::kPause, kSuspended},
    {kPreparing, Event::kResume, kPreparing},
    {kPausing, Event::kResume, kRunning},
    {kPaused, Event::kResume, kRunning},
    {kAsking, Event::kResume, kAsking},
    {kSuspended, Event::kResume, kSuspended},
    // Where nothing is measured, silence is waited for when the run goes on.
    {kRunning, Event::kSilence, kSuspended},
    {kPausing, Event::kSilence, kSuspended},
    {kSuspended, Event::kSilence, kSuspended},
    {kPaused, Event::kSilence, kPaused},
    {kAsking, Event::kSilence, kAsking},
    {kSuspended, Event::kBack, kRunning},
    // The end of a run.
    {kPreparing, Event::kStop, kStopping},
    {kRunning, Event::kStop, kStopping},
    {kPausing, Event::kStop, kStopping},
    {kPaused, Event::kStop, kStopping},
    {kAsking, Event::kStop, kStopping},
    {kSuspended, Event::kStop, kStopping},
    {kStopping, Event::kStop, kStopping},
    {kPreparing, Event::kAbort, kStopping},
    {kRunning, Event::kAbort, kStopping},
    {kPausing, Event::kAbort, kStopping},
    {kPaused, Event::kAbort, kStopping},
    {kAsking, Event::kAbort, kStopping},
    {kSuspended, Event::kAbort, kStopping},
    {kStopping, Event::kAbort, kStopping},
    {kPreparing, Event::kTrip, kStopping},
    {kRunning, Event::kTrip, kStopping},
    {kPausing, Event::kTrip, kStopping},
    {kPaused, Event::kTrip, kStopping},
    {kAsking, Event::kTrip, kStopping},
    {kSuspended, Event::kTrip, kStopping},
    {kStopping, Event::kTrip, kStopping},
    {kPreparing, Event::kFinish, kStopping},
    {kRunning, Event::kFinish, kStopping},
    {kPausing, Event::kFinish, kStopping},
    {kSuspended, Event::kFinish, kStopping},
    {kStopping, Event::kFinish, kStopping},
    {kStopping, Event::kEnded, kIdle},
    {kStopping, Event::kFailed, kFault},
};

constexpr std::array<const char*, kStates> kStateNames = {
    "idle",  "running", "paused",       "asking",    "stopping",
    "fault", "pausing", "disconnected", "preparing", "suspended"};
constexpr std::array<const char*, kEvents> kEventNames = {
    "device lost", "all well", "begin",      "commission", "prepared", "ask",  "answer",
    "pause",       "resume",   "safe point", "silence",    "back",     "stop", "abort",
    "trip",        "finish",   "ended",      "failed",     "reset"};

}  // namespace

const char* Name(State state) { return kStateNames.at(static_cast<std::size_t>(state)); }

const char* Name(Event event) { return kEventNames.at(static_cast<std::size_t>(event)); }

std::span<const Transition> Transitions() { return kTransitions; }

std::optional<State> Next(State from, Event event) {
  const auto* found = std::ranges::find_if(kTransitions, [&](const Transition& transition) {
    return transition.from == from && transition.event == event;
  });
  if (found == std::end(kTransitions)) return std::nullopt;
  return found->to;
}

}  // namespace gyrobench::daemon
