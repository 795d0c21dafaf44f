// The states of the stand: the table of the document is that of the code, and the stand goes by it.
#include "daemon/stand_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "daemon/run_control.h"
#include "procedures/engine/engine.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::daemon {
namespace {

using Line = std::tuple<std::string, std::string, std::string>;

std::vector<std::string> Split(const std::string& text, char at) {
  std::vector<std::string> parts;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, at);) {
    const auto begin = part.find_first_not_of(' ');
    if (begin == std::string::npos) continue;
    parts.push_back(part.substr(begin, part.find_last_not_of(' ') - begin + 1));
  }
  return parts;
}

// One for each state of the first column.
std::set<Line> LinesOfTheDocument() {
  std::ifstream file(GYROBENCH_SOURCE_DIR "/docs/reliability.md");
  std::set<Line> lines;
  bool in_table = false;
  for (std::string text; std::getline(file, text);) {
    if (text.starts_with("| state | event |")) {
      in_table = true;
      continue;
    }
    if (!text.starts_with("|")) in_table = false;
    if (!in_table || text.starts_with("|---")) continue;
    const std::vector<std::string> cells = Split(text, '|');
    for (const std::string& from : Split(cells.at(0), ','))
      lines.insert({from, cells.at(1), cells.at(2) == "the same" ? from : cells.at(2)});
  }
  return lines;
}

TEST(StandState, TheDocumentsTableIsThatOfTheCode) {
  std::set<Line> code;
  for (const Transition& line : Transitions())
    code.insert({Name(line.from), Name(line.event), Name(line.to)});
  EXPECT_EQ(LinesOfTheDocument(), code);
  EXPECT_EQ(code.size(), Transitions().size()) << "no state leads to two by one event";
}

TEST(StandState, NoStateIsADeadEndAndAStopFitsEveryState) {
  for (int i = 0; i < kStates; ++i) {
    const auto state = static_cast<State>(i);
    EXPECT_TRUE(Next(state, Event::kStop)) << Name(state);
    EXPECT_TRUE(Next(state, Event::kTrip)) << Name(state);
    EXPECT_TRUE(std::ranges::any_of(Transitions(), [&](const Transition& line) {
      return line.from == state && line.to != state;
    })) << Name(state);
  }
}

// A stand that is taken to a state by what leads there, with the test as the run's thread.
class Stand {
 public:
  explicit Stand(State state) {
    switch (state) {
      case State::kIdle:
        break;
      case State::kDisconnected:
        control.SetAllWell(false);
        break;
      case State::kFault:
        control.Report(kFault);
        break;
      case State::kPreparing:
        control.BeginRun(*run);
        break;
      default:
        control.BeginRun(*run);
        control.Prepared();
    }
    if (state == State::kPausing || state == State::kPaused) control.Pause();
    if (state == State::kSuspended) control.Suspend(kFault);
    if (state == State::kStopping) control.BeginStopping();
    EXPECT_TRUE(state == State::kPaused || state == State::kAsking || control.state() == state);
  }
  // In the states in which the run's thread waits, the event comes while it does.
  State After(State state, const std::function<void()>& act) {
    State after{};
    const auto somebody = [&](Clock::Participant* other) {
      while (control.state() != state) other->WaitUntil(clock->Now() + 1);
      act();
      after = control.state();
      if (control.run_is_on()) control.Stop("the test is over");
    };
    if (state != State::kPaused && state != State::kAsking) {
      act();
      after = control.state();
      if (control.run_is_on()) control.EndRun();
      return after;
    }
    std::thread beside([&, other = clock->Join("somebody")]() mutable {
      somebody(other.get());
      other.reset();
    });
    try {
      if (state == State::kPaused) control.WaitWhilePaused();
      const procedures::Question question{"cool", "Cool the gyro", {}, 100.0};
      if (state == State::kAsking) control.WaitForAnswer(*clock, question, kStart + 100'000'000);
    } catch (const std::exception&) {  // it was ended
    }
    beside.join();
    if (control.run_is_on()) control.EndRun();
    return after;
  }
  // By the public way; of the events that come from the run's thread, as it calls them.
  void Do(Event event) {
    const std::map<Event, std::function<void()>> acts = {
        {Event::kDeviceLost, [this] { control.SetAllWell(false); }},
        {Event::kAllWell, [this] { control.SetAllWell(true); }},
        {Event::kBegin, [this] { control.BeginRun(*run); }},
        {Event::kCommission,
         [this] { control.BeginRun(*run, std::nullopt, RunControl::Devices::kMayBeUnwell); }},
        {Event::kPrepared, [this] { control.Prepared(); }},
        {Event::kAnswer, [this] { control.Answer("done"); }},
        {Event::kPause, [this] { control.Pause(); }},
        {Event::kResume,
         [this] {
           if (control.state() != State::kRunning && !control.pause_wanted()) control.Pause();
           control.Resume();
         }},
        {Event::kSilence, [this] { control.Suspend(kFault); }},
        {Event::kBack, [this] { control.BeginHold(), control.EndHold(control.silences()); }},
        {Event::kStop, [this] { control.Stop("stopped"); }},
        {Event::kAbort, [this] { control.Abort(); }},
        {Event::kTrip, [this] { control.Report(kFault); }},
        {Event::kFinish, [this] { control.BeginStopping(); }},
        {Event::kEnded, [this] { control.EndRun(); }},
        {Event::kFailed, [this] { control.Report(kFault), control.EndRun(); }},
        {Event::kReset, [this] { control.ClearFault(); }}};
    acts.at(event)();
  }

  static inline const Fault kFault{"axis.inner", "lost steps"};
  std::unique_ptr<VirtualClock> clock = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> run = clock->Join("run");
  RunControl control;
};

// Ask and safe point are where the states asking and paused are made; the end of a run finishes it.
bool IsThePublicWay(Event event) { return event != Event::kAsk && event != Event::kSafePoint; }

TEST(StandState, TheStandGoesByEveryLineOfTheTable) {
  for (const Transition& line : Transitions()) {
    if (!IsThePublicWay(line.event)) continue;
    Stand stand(line.from);
    EXPECT_EQ(stand.After(line.from, [&] { stand.Do(line.event); }), line.to)
        << Name(line.from) << ", " << Name(line.event);
  }
}

// What an operator asks for is refused, and all else passes by.
TEST(StandState, WhatIsNotInTheTableChangesNothing) {
  for (int i = 0; i < kStates; ++i) {
    for (const Event event : {Event::kDeviceLost, Event::kAllWell, Event::kBegin,
                              Event::kCommission, Event::kPrepared, Event::kAnswer, Event::kPause,
                              Event::kResume, Event::kSilence, Event::kAbort, Event::kReset}) {
      const auto state = static_cast<State>(i);
      if (Next(state, event)) continue;
      const bool asked = event == Event::kBegin || event == Event::kCommission ||
                         event == Event::kAnswer || event == Event::kPause ||
                         event == Event::kResume || event == Event::kAbort ||
                         event == Event::kReset;
      Stand stand(state);
      const State after = stand.After(state, [&] {
        if (asked) {
          EXPECT_THROW(stand.Do(event), StateError) << Name(state) << ", " << Name(event);
        } else {
          stand.Do(event);
        }
      });
      EXPECT_EQ(after, state) << Name(state) << ", " << Name(event);
    }
  }
}

}  // namespace
}  // namespace gyrobench::daemon
