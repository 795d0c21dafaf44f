// Of the bench that moves: turns, swings, rests and soaks.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "daemon/bench_facts.h"
#include "daemon/live_bench.h"
#include "daemon/polled_device.h"
#include "procedures/engine/motion_time.h"
#include "procedures/engine/settling.h"

namespace gyrobench::daemon {
namespace {

// A long soak reports a result a minute.
constexpr double kSoakSegment_s = 60.0;
constexpr double kTemperaturePeriod_s = 1.0;
constexpr Utime kMovePoll = kMicrosecondsPerSecond / 20;
// Within a swing the next move is to follow at once.
constexpr Utime kSwingPoll = kMicrosecondsPerSecond / 500;
// The table swings out after a move; the reference is read for "moved" after this.
constexpr double kSwingOut_s = 0.1;
constexpr Utime kSamplesPoll = kMicrosecondsPerSecond / 100;

std::string SoakText(double temperature_degC, const procedures::Settling& settling,
                     const procedures::SoakCommand& command) {
  if (std::isnan(settling.change_degC())) {
    return fmt::format("{:.2f} degC, watched for less than {:g} s", temperature_degC,
                       command.window_s);
  }
  return fmt::format("{:.2f} degC, {:.2f} degC within {:g} s (settled below {:g})",
                     temperature_degC, settling.change_degC(), command.window_s,
                     command.drift_degC);
}

}  // namespace

double LiveBench::StartMove(const procedures::TurnCommand& command) {
  return context_.acquisition.MoveBy(context_.participant, command.axis, command.angle_deg,
                                     command.rate_deg_s, command.acceleration_deg_s2,
                                     [this] { context_.control.ThrowIfToEnd(); });
}

// One that does not end is a fault (MotionGuard), of which Wait hears.
AxisView LiveBench::WaitForEndOfMove(const std::string& axis, double expected_s, Utime poll) {
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(expected_s));
  for (;;) {
    const AxisView view = context_.acquisition.ReadNow(context_.participant, axis);
    if (!view.drive.moving) return view;
    context_.control.Wait(context_.clock, context_.clock.Now() + poll);
  }
}

// A silence is told only after silence_s: what was measured in its first moments would seem whole.
void LiveBench::AwaitSamples() {
  const Utime begin = context_.clock.Now();
  const Utime until = begin - FromSeconds(kSwingOut_s);
  const Utime deadline = begin + FromSeconds(context_.stand.safety.silence_s) + kFoundWithin;
  while (!context_.acquisition.HasSampleOf(until)) {
    if (context_.clock.Now() >= deadline)
      return spdlog::warn("{}: samples of its end did not come", progress_.segment);
    context_.control.Wait(context_.clock, context_.clock.Now() + kSamplesPoll);
  }
}

void LiveBench::CheckFollowing(const procedures::TurnCommand& command, double moved_deg) {
  const double allowed = ConfigOf(context_.stand, command.axis).following_error_deg;
  if (std::abs(moved_deg - command.angle_deg) <= allowed) return;
  throw FaultError(
      {"axis." + command.axis,
       fmt::format(
           "turn failed: the reference sensor moved {:.3f} deg, commanded {:.3f} deg, "
           "allowed difference {:g} deg (lost steps, a limit or stop input of the drive, a "
           "loose coupling, or a wrong gear ratio or encoder resolution in the stand file?)",
           moved_deg, command.angle_deg, allowed),
       {.device = "axis." + command.axis, .action = "move"}});
}

procedures::TurnOutcome LiveBench::Turn(const procedures::TurnCommand& command) {
  procedures::TurnOutcome outcome;
  Resumably([&] { outcome = TurnOnce(command); });
  return outcome;
}

procedures::TurnOutcome LiveBench::TurnOnce(const procedures::TurnCommand& command) {
  AxisView before = context_.acquisition.ReadNow(context_.participant, command.axis);
  const procedures::AxisFacts facts =
      FactsOf(ConfigOf(context_.stand, command.axis), before.reference.angle_deg);
  procedures::CheckTurn(command, facts);
  BeginSegment("turn", fmt::format("{} {:+g} deg", command.axis, command.angle_deg));
  const double rate = StartMove(command);
  WaitForEndOfMove(command.axis,
                   procedures::MoveDuration_s(command.angle_deg, rate, command.acceleration_deg_s2),
                   kMovePoll);
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kSwingOut_s));
  const AxisView after = context_.acquisition.ReadNow(context_.participant, command.axis);
  const double moved = after.reference.angle_deg - before.reference.angle_deg;
  CheckFollowing(command, moved);
  const double duration = ToSeconds(context_.clock.Now() - segment_begin_);
  EndSegment();
  return {moved, rate, duration};
}

procedures::SwingOutcome LiveBench::Swing(const procedures::SwingCommand& command) {
  procedures::SwingOutcome outcome;
  Resumably([&] { outcome = SwingOnce(command); });
  return outcome;
}

procedures::SwingOutcome LiveBench::SwingOnce(const procedures::SwingCommand& command) {
  const std::vector<procedures::TurnCommand> moves = procedures::MovesOf(command);
  const AxisView before = context_.acquisition.ReadNow(context_.participant, command.axis);
  procedures::AxisFacts facts =
      FactsOf(ConfigOf(context_.stand, command.axis), before.reference.angle_deg);
  for (const procedures::TurnCommand& move : moves) {
    procedures::CheckTurn(move, facts);
    facts.angle_deg += move.angle_deg;
  }
  BeginSegment("swing", procedures::Describe(command));
  for (const procedures::TurnCommand& move : moves) {
    const double rate = StartMove(move);
    WaitForEndOfMove(move.axis,
                     procedures::MoveDuration_s(move.angle_deg, rate, move.acceleration_deg_s2),
                     kSwingPoll);
  }
  const double duration = ToSeconds(context_.clock.Now() - segment_begin_);
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kSwingOut_s));
  const AxisView after = context_.acquisition.ReadNow(context_.participant, command.axis);
  // Home again: as a move by nothing.
  CheckFollowing({command.axis, 0.0, moves[0].rate_deg_s, moves[0].acceleration_deg_s2},
                 after.reference.angle_deg - before.reference.angle_deg);
  EndSegment();
  // Home to side takes a third of a period, side to side half of one.
  const double periods = static_cast<double>(command.periods) + 1.0 / 6.0;
  return {periods / duration, duration};
}

void LiveBench::Rest(double duration_s) {
  Resumably([&] { RestOnce(duration_s); });
}

void LiveBench::RestOnce(double duration_s) {
  BeginSegment("rest", fmt::format("{:g} s", duration_s));
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(duration_s));
  EndSegment();
}

procedures::SoakOutcome LiveBench::Soak(const procedures::SoakCommand& command) {
  procedures::SoakOutcome outcome;
  Resumably([&] { outcome = SoakOnce(command); });
  return outcome;
}

procedures::SoakOutcome LiveBench::SoakOnce(const procedures::SoakCommand& command) {
  const double begin_s = ElapsedS();
  // The plan's time since the start has no operator's time in it.
  const double planned_begin_s = begin_s - waited_s_;
  const double after_s =
      std::max(0.0, planned_s_ - begin_s - procedures::ExpectedSoak_s(command, planned_begin_s));
  procedures::Settling settling(command, planned_begin_s);
  int part = 1;
  BeginSegment("soak", fmt::format("minute {}", part));
  double part_end_s = begin_s + kSoakSegment_s;
  while (!settling.settled() && ElapsedS() - begin_s < command.max_s) {
    context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kTemperaturePeriod_s));
    const double temperature_degC = TemperatureDegC();
    settling.Add(ElapsedS() - begin_s, temperature_degC);
    planned_s_ = ElapsedS() + settling.remaining_s() + after_s;
    progress_.message = SoakText(temperature_degC, settling, command);
    if (ElapsedS() >= part_end_s && !settling.settled()) {
      EndSegment();
      context_.control.ThrowIfToEnd();
      PauseIfWanted();
      BeginSegment("soak", fmt::format("minute {}", ++part));
      part_end_s += kSoakSegment_s;
    }
  }
  planned_s_ = ElapsedS() + after_s;
  EndSegment();
  progress_.message.clear();
  return {settling.settled(), ElapsedS() - begin_s, TemperatureDegC()};
}

}  // namespace gyrobench::daemon
