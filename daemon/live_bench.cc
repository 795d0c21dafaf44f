#include "daemon/live_bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/json_text.h"
#include "daemon/bench_facts.h"
#include "daemon/run_trace.h"
#include "drivers/modbus_bus.h"
#include "procedures/engine/bench.h"
#include "procedures/engine/motion_time.h"
#include "procedures/engine/settling.h"

namespace gyrobench::daemon {
namespace {

// A long soak reports a result a minute.
constexpr double kSoakSegment_s = 60.0;
constexpr double kTemperaturePeriod_s = 1.0;
constexpr std::size_t kMostSaid = 10'000;
constexpr Utime kMovePoll = kMicrosecondsPerSecond / 20;
// Within a swing the next move is to follow at once.
constexpr Utime kSwingPoll = kMicrosecondsPerSecond / 500;
// Of one command; more is a device that does not stay.
constexpr int kMostInterruptions = 3;
// A turn is measured from stop to stop: the one that it begins from was not measured, or is gone.
constexpr double kRestBefore_s = 2.0;
// The table swings out after a move; the reference is read for "moved" after this.
constexpr double kSettle_s = 0.1;

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

const config::AxisConfig& ConfigOf(const config::StandConfig& stand, const std::string& name) {
  for (const config::AxisConfig& axis : stand.axes) {
    if (axis.name == name) return axis;
  }
  throw LimitError(fmt::format("this stand has no axis '{}'", name));
}

}  // namespace

LiveBench::LiveBench(Context context, Utime start)
    : context_(std::move(context)),
      suspension_({context_.stand, context_.clock, context_.participant, context_.acquisition,
                   context_.control}),
      start_(start),
      planned_s_(context_.planned_duration_s),
      analysis_(context_.clock, context_.telemetry) {}

double LiveBench::ElapsedS() const { return ToSeconds(context_.clock.Now() - start_); }

std::vector<procedures::AxisFacts> LiveBench::Axes() const {
  std::vector<procedures::AxisFacts> facts;
  for (const config::AxisConfig& axis : context_.stand.axes) {
    facts.push_back(FactsOf(axis, context_.acquisition.Axis(axis.name).reference.angle_deg));
  }
  return facts;
}

StandGeometry LiveBench::Geometry() const { return context_.stand.geometry; }

double LiveBench::TemperatureDegC() const { return context_.acquisition.Sensor().temperature_degC; }

std::vector<std::string> LiveBench::Outputs() const {
  std::vector<std::string> names;
  const daemon::Outputs* outputs = context_.acquisition.outputs();
  if (outputs == nullptr) return names;
  for (const auto& [output, on] : outputs->States()) names.push_back(output);
  return names;
}

void LiveBench::SwitchOutput(const std::string& output, bool on) {
  daemon::Outputs* outputs = context_.acquisition.outputs();
  if (outputs == nullptr) throw LimitError("this stand has no outputs that could be switched");
  Resumably([&] {
    outputs->Switch(context_.participant, output, on, [this] { context_.control.ThrowIfToEnd(); });
  });
  Say(output + (on ? " switched on" : " switched off"));
}

run_t LiveBench::Message(std::int8_t event) const {
  run_t message{};
  message.utime = context_.clock.Now();
  message.event = event;
  message.segment_kind = segment_kind_;
  message.segment_name = progress_.segment;
  message.segment_begin_utime = segment_begin_;
  message.segments_done = progress_.segments_done;
  message.progress = progress_.fraction;
  message.remaining_s = progress_.remaining_s;
  return message;
}

void LiveBench::BeginSegment(const std::string& kind, const std::string& name) {
  traced_.reset();
  segment_kind_ = kind;
  segment_begin_ = context_.clock.Now();
  progress_.segment = name;
  run_t message = Message(run_t::SEGMENT_BEGIN);
  context_.telemetry.Send(message);
  context_.on_progress(progress_);
}

// By the dry run's time and what soaks have shown since.
void LiveBench::UpdateTime() {
  const double elapsed = ElapsedS();
  meter_.AtTime(elapsed - waited_s_, planned_s_ - waited_s_);
  progress_.fraction = meter_.fraction();
  progress_.remaining_s = elapsed < planned_s_ ? planned_s_ - elapsed : kMissing;
}

void LiveBench::AddWaiting(double begin_s) {
  const double waited_s = ElapsedS() - begin_s;
  waited_s_ += waited_s;
  planned_s_ += waited_s;
}

void LiveBench::EndSegment() {
  ++progress_.segments_done;
  UpdateTime();
  run_t message = Message(run_t::SEGMENT_END);
  context_.telemetry.Send(message);
  analysis_.Begin(message.utime);
  context_.on_progress(progress_);
}

template <typename Command>
auto LiveBench::Resumably(const Command& command) -> decltype(command()) {
  for (int interruptions = 0;; ++interruptions) {
    // While it was paused, or asked.
    const auto earlier = context_.control.suspended();
    if (earlier) Interrupt(suspension_.Here(), *earlier);
    const Suspension::Point point = suspension_.Here();
    Fault silent;
    try {
      if (earlier || interruptions > 0) {
        context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kRestBefore_s));
      }
      return command();
    } catch (const Suspended& suspended) {
      if (interruptions == kMostInterruptions) throw FaultError(suspended.fault());
      silent = suspended.fault();
    } catch (const drivers::RefusedByDevice&) {
      throw;
    } catch (const DeviceError& error) {  // before its poll has told that it is silent
      const bool waits = context_.stand.safety.resume_within_s > 0;
      if (interruptions == kMostInterruptions || !waits) throw;
      silent = FaultOf("device", error);
      if (!context_.control.Suspend(silent)) throw;
    }
    Interrupt(point, silent);
  }
}

void LiveBench::Interrupt(const Suspension::Point& point, const Fault& silent) {
  const double begin_s = ElapsedS();
  run_t suspend = Message(run_t::SUSPEND);
  suspend.text = silent.source + ": " + silent.message;
  context_.telemetry.Send(suspend);
  progress_.message = "suspended: " + suspend.text;
  context_.on_progress(progress_);
  suspension_.WaitAndGoBack(point, silent);
  AddWaiting(begin_s);
  run_t go_on = Message(run_t::CONTINUE);
  go_on.text = fmt::format("{} is back after {:.1f} s: the command under way begins again",
                           silent.source, ElapsedS() - begin_s);
  context_.telemetry.Send(go_on);
  Say("suspended: " + suspend.text + "; " + go_on.text);
}

void LiveBench::Record(const FinishedCommand& command) {
  run_t message = Message(run_t::COMMAND);
  message.text = command.command;
  message.outcome = JsonText(command.outcome);
  context_.telemetry.Send(message);
}

void LiveBench::TakeUp(const ResumedRun& run) {
  progress_.segments_done = run.segments_done;
  suspension_.GoTo(run.angles_deg);
  AddWaiting(ToSeconds(run.last - start_));
  run_t go_on = Message(run_t::CONTINUE);
  go_on.text = fmt::format("run {} is taken up, {:.0f} s after the last command that was over",
                           run.from.run_id(), ToSeconds(context_.clock.Now() - run.last));
  context_.telemetry.Send(go_on);
  analysis_.Begin(go_on.utime);
  Say(go_on.text);
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kRestBefore_s));
}

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

void LiveBench::CheckFollowing(const procedures::TurnCommand& command, double moved_deg) {
  const double allowed = ConfigOf(context_.stand, command.axis).following_error_deg;
  if (std::abs(moved_deg - command.angle_deg) <= allowed) return;
  throw FaultError(
      {"axis." + command.axis,
       fmt::format("turn failed: the reference sensor moved {:.3f} deg, commanded {:.3f} deg, "
                   "allowed difference {:g} deg (lost steps, a loose coupling, or a wrong gear "
                   "ratio or encoder resolution in the stand file?)",
                   moved_deg, command.angle_deg, allowed),
       {.device = "axis." + command.axis, .action = "move"}});
}

procedures::TurnOutcome LiveBench::Turn(const procedures::TurnCommand& command) {
  return Resumably([&] { return TurnOnce(command); });
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
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kSettle_s));
  const AxisView after = context_.acquisition.ReadNow(context_.participant, command.axis);
  const double moved = after.reference.angle_deg - before.reference.angle_deg;
  CheckFollowing(command, moved);
  const double duration = ToSeconds(context_.clock.Now() - segment_begin_);
  EndSegment();
  return {moved, rate, duration};
}

procedures::SwingOutcome LiveBench::Swing(const procedures::SwingCommand& command) {
  return Resumably([&] { return SwingOnce(command); });
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
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kSettle_s));
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
  return Resumably([&] { return RestOnce(duration_s); });
}

void LiveBench::RestOnce(double duration_s) {
  BeginSegment("rest", fmt::format("{:g} s", duration_s));
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(duration_s));
  EndSegment();
}

procedures::SoakOutcome LiveBench::Soak(const procedures::SoakCommand& command) {
  return Resumably([&] { return SoakOnce(command); });
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
      SafePoint();
      BeginSegment("soak", fmt::format("minute {}", ++part));
      part_end_s += kSoakSegment_s;
    }
  }
  planned_s_ = ElapsedS() + after_s;
  EndSegment();
  progress_.message.clear();
  return {settling.settled(), ElapsedS() - begin_s, TemperatureDegC()};
}

std::string LiveBench::Ask(const procedures::Question& question) {
  run_t message = Message(run_t::QUESTION);
  message.text = question.text;
  for (const std::string& choice : question.choices) {
    message.choices += (message.choices.empty() ? "" : "\n") + choice;
  }
  context_.telemetry.Send(message);
  std::optional<std::string> answer;
  if (context_.stand.virtual_stand) {
    const auto& answers = context_.stand.virtual_stand->answers;
    if (const auto found = answers.find(question.id); found != answers.end()) {
      answer = found->second;
      context_.on_configured_answer(question.id);
    }
  }
  if (!answer) {
    const double begin_s = ElapsedS();
    const bool still = context_.set_asking_pace(true);
    const Utime deadline =
        still ? kForever : context_.clock.Now() + FromSeconds(question.timeout_s);
    answer = context_.control.WaitForAnswer(context_.clock, question, deadline);
    context_.set_asking_pace(false);
    AddWaiting(begin_s);
  }
  if (!answer) {
    throw Error(
        fmt::format("nobody answered '{}' ({}) within {:g} s: the run was ended; run it again when "
                    "somebody is there to answer (gyrobench answer), or let it wait longer",
                    question.text, question.id, question.timeout_s));
  }
  for (const std::string& output : procedures::KnownOutputs()) {
    if (question.id == procedures::SwitchQuestion(output, true).id) on_by_hand_.insert(output);
    if (question.id == procedures::SwitchQuestion(output, false).id) on_by_hand_.erase(output);
  }
  run_t reply = Message(run_t::ANSWER);
  reply.text = *answer;
  context_.telemetry.Send(reply);
  return *answer;
}

procedures::Estimate LiveBench::ReadEstimate(const std::string& what) {
  const calibration::AnalysisResult results = analysis_.Newest(context_.participant);
  if (what == "scale_factor" && !results.scale.empty()) {
    const calibration::ScaleResult& scale = results.scale.front();
    return {true, scale.alpha, scale.alpha_std_error, "deg/s per LSB"};
  }
  if (what == "bias" && !results.bias.empty() && !results.bias.front().coefficients.empty()) {
    const calibration::BiasResult& bias = results.bias.front();
    return {true, bias.coefficients.front(), bias.std_errors.front(), "LSB"};
  }
  return {};
}

std::vector<procedures::AxisVerdict> LiveBench::Trace() {
  traced_ = TraceRun(context_.telemetry.Recorded(), TraceFor::kProcedure);
  std::vector<procedures::AxisVerdict> verdicts;
  if (!traced_) return verdicts;
  context_.telemetry.SendTrace(traced_->result, context_.clock.Now(), false);
  context_.telemetry.SendModel(*traced_, context_.clock.Now(), false);
  for (const calibration::ChannelTrace& channel : traced_->result.channels)
    verdicts.push_back(VerdictOf(channel));
  return verdicts;
}

procedures::Choice LiveBench::Choose(const std::vector<procedures::Rehearsal>& menu,
                                     double small_below) {
  const calibration::Recording recording = context_.telemetry.Recorded();
  if (!traced_) traced_ = TraceRun(recording, TraceFor::kProcedure);
  if (!traced_) throw DataError("nothing has been measured yet that could be traced");
  procedures::Choice choice = ChooseAmong(menu, small_below, recording, *traced_, loop_);
  if (!choice.best) return choice;
  // The verdicts once more, with what is asked for and why.
  const procedures::Rehearsal& best = menu[*choice.best];
  calibration::TraceResult told = traced_->result;
  for (calibration::ChannelTrace& channel : told.channels) {
    channel.summary +=
        fmt::format(" Next: {}, {:.1f} min; it {} (chi-square {:.1f} expected).", best.name,
                    best.duration_s / 60.0, choice.because, 2.0 * choice.nats);
  }
  context_.telemetry.SendTrace(told, context_.clock.Now(), false);
  return choice;
}

void LiveBench::RecordLimit(const procedures::LimitCheck& check) {
  limits_.push_back(check);
  Say(Describe(check));
}

void LiveBench::Say(const std::string& text) {
  if (said_.size() < kMostSaid) said_.push_back({ElapsedS(), text});
  run_t message = Message(run_t::NOTE);
  message.text = text;
  context_.telemetry.Send(message);
  progress_.message = text;
  context_.on_progress(progress_);
}

void LiveBench::Progress(double fraction) {
  meter_.Report(fraction);
  progress_.fraction = meter_.fraction();
  run_t message = Message(run_t::PROGRESS);
  context_.telemetry.Send(message);
  context_.on_progress(progress_);
}

void LiveBench::SafePoint() {
  Resumably([this] { context_.control.ThrowIfToEnd(); });
  if (!context_.control.pause_wanted()) return;
  run_t pause = Message(run_t::PAUSE);
  context_.telemetry.Send(pause);
  const double begin_s = ElapsedS();
  context_.set_asking_pace(true);
  context_.control.WaitWhilePaused();
  context_.set_asking_pace(false);
  AddWaiting(begin_s);
  run_t resume = Message(run_t::RESUME);
  context_.telemetry.Send(resume);
}

}  // namespace gyrobench::daemon
