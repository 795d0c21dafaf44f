#include "daemon/live_bench.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <exception>
#include <utility>

#include "base/error.h"
#include "base/json_text.h"
#include "daemon/bench_facts.h"
#include "daemon/journal_bench.h"
#include "daemon/resumed_run.h"
#include "daemon/run_trace.h"
#include "drivers/modbus_bus.h"
#include "procedures/engine/bench.h"

namespace gyrobench::daemon {
namespace {

constexpr std::size_t kMostSaid = 10'000;
// Of one command; more is a device that does not stay.
constexpr int kMostInterruptions = 3;
// A turn is measured from stop to stop: the one that it begins from was not measured, or is gone.
constexpr double kRestBefore_s = 2.0;

// Virtual time at its idle pace, until somebody answers or the wait ends in an error.
class AskingPace {
 public:
  explicit AskingPace(const std::function<bool(bool)>& set) : set_(set), still_(set(true)) {}
  ~AskingPace() { set_(false); }
  AskingPace(const AskingPace&) = delete;
  AskingPace& operator=(const AskingPace&) = delete;
  bool still() const { return still_; }

 private:
  const std::function<bool(bool)>& set_;
  const bool still_;
};

// Of an answer that the stand file gives.
void RequireChoice(const procedures::Question& question, const std::string& answer) {
  if (question.choices.empty() ||
      std::ranges::find(question.choices, answer) != question.choices.end())
    return;
  throw Error(fmt::format("virtual.answers.{} = \"{}\" is no answer to '{}': expected one of {}",
                          question.id, answer, question.text, fmt::join(question.choices, ", ")));
}

}  // namespace

LiveBench::LiveBench(Context context, Utime start)
    : context_(std::move(context)),
      suspension_({context_.stand, context_.clock, context_.participant, context_.acquisition,
                   context_.control}),
      last_good_(suspension_.Here()),
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
  if (!on) switched_on_.erase(output);
  Resumably([&] {
    outputs->Switch(context_.participant, output, on, [this] { context_.control.ThrowIfToEnd(); });
  });
  if (on) switched_on_.insert(output);
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
  // One in which a device fell silent is begun again.
  context_.control.ThrowIfToEnd();
  AwaitSamples();
  ++progress_.segments_done;
  UpdateTime();
  run_t message = Message(run_t::SEGMENT_END);
  context_.telemetry.Send(message);
  analysis_.Begin(message.utime);
  context_.on_progress(progress_);
}

void LiveBench::Resumably(const std::function<void()>& command) {
  for (int interruptions = 0;; ++interruptions) {
    try {
      if (const auto silent = context_.control.suspended()) {
        Interrupt(*silent);
        context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kRestBefore_s));
      }
      command();
      return KeepPoint();
    } catch (const Suspended& suspended) {
      if (interruptions == kMostInterruptions) throw FaultError(suspended.fault());
    } catch (const DeviceError& error) {
      SuspendOrRethrow(error, interruptions < kMostInterruptions);
    }
  }
}

void LiveBench::SuspendOrRethrow(const DeviceError& error, bool may_wait) {
  // A reply that was lost because a stop hurried is no fault.
  if (context_.control.IsToEnd()) context_.control.ThrowIfToEnd();
  // Before its poll has told that it is silent. A device that refuses, or reports an alarm, is not.
  const bool silent = dynamic_cast<const drivers::NoAnswer*>(&error) != nullptr;
  const bool waits = silent && may_wait && context_.stand.safety.resume_within_s > 0;
  if (waits && context_.control.Suspend(FaultOfDevice(error))) return;
  std::rethrow_exception(std::current_exception());
}

void LiveBench::KeepPoint() {
  Suspension::Point here = suspension_.Here();
  // After it: what is told later was not read.
  context_.control.ThrowIfToEnd();
  last_good_ = std::move(here);
}

void LiveBench::Interrupt(const Fault& silent) {
  const double begin_s = ElapsedS();
  const std::string outputs = fmt::format("{}", fmt::join(switched_on_, " and "));
  run_t suspend = Message(run_t::SUSPEND);
  suspend.text = TextOf(silent);
  if (!outputs.empty()) suspend.text += "; meanwhile switched off: " + outputs;
  context_.telemetry.Send(suspend);
  progress_.message = fmt::format("suspended: {}; waits up to {:g} s for it", suspend.text,
                                  context_.stand.safety.resume_within_s);
  context_.on_progress(progress_);
  suspension_.WaitAndGoBack(last_good_, silent, switched_on_);
  AddWaiting(begin_s);
  const double silent_s = ElapsedS() - begin_s;
  ++suspensions_.count;
  suspensions_.duration_s += silent_s;
  suspensions_.devices.insert(silent.source);
  run_t go_on = Message(run_t::CONTINUE);
  go_on.text =
      fmt::format("{} is back after {:.1f} s: {}the command under way begins again", silent.source,
                  silent_s, outputs.empty() ? "" : outputs + " switched on again, ");
  context_.telemetry.Send(go_on);
  spdlog::info("run goes on: {}", go_on.text);
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
  KeepPoint();
  AddWaiting(ToSeconds(run.last - start_));
  run_t go_on = Message(run_t::CONTINUE);
  go_on.text = fmt::format("run {} is taken up, {:.0f} s after the last command that was over",
                           run.from.run_id(), ToSeconds(context_.clock.Now() - run.last));
  context_.telemetry.Send(go_on);
  analysis_.Begin(go_on.utime);
  Say(go_on.text);
  context_.control.Wait(context_.clock, context_.clock.Now() + FromSeconds(kRestBefore_s));
}

std::string LiveBench::Ask(const procedures::Question& question) {
  run_t message = Message(run_t::QUESTION);
  message.text = question.text;
  for (const std::string& choice : question.choices) {
    message.choices += (message.choices.empty() ? "" : "\n") + choice;
  }
  context_.telemetry.Send(message);
  std::optional<std::string> answer;
  bool waited = false;
  if (context_.stand.virtual_stand) {
    const auto& answers = context_.stand.virtual_stand->answers;
    if (const auto found = answers.find(question.id); found != answers.end()) {
      RequireChoice(question, found->second);
      answer = found->second;
      context_.on_configured_answer(question.id);
    }
  }
  if (!answer) {
    const double begin_s = ElapsedS();
    // Nothing was measured yet: it may be unplugged to be cooled, or mounted.
    if (progress_.segments_done == 0) last_good_.starts.reset();
    const AskingPace pace(context_.set_asking_pace);
    const Utime deadline =
        pace.still() ? kForever : context_.clock.Now() + FromSeconds(question.timeout_s);
    answer = context_.control.WaitForAnswer(context_.clock, question, deadline);
    AddWaiting(begin_s);
    waited = true;
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
  // Somebody was at the stand.
  if (waited && !context_.commissions)
    Resumably([this] { suspension_.RequireSame(last_good_, "a question"); });
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
  Resumably([this] {
    context_.control.ThrowIfToEnd();
    PauseIfWanted();
  });
}

void LiveBench::PauseIfWanted() {
  if (!context_.control.pause_wanted()) return;
  run_t pause = Message(run_t::PAUSE);
  context_.telemetry.Send(pause);
  const double begin_s = ElapsedS();
  {
    const AskingPace pace(context_.set_asking_pace);
    std::optional<Utime> silent_since;
    context_.control.WaitWhilePaused([&] { return suspension_.LookInPause(silent_since); });
  }
  AddWaiting(begin_s);
  run_t resume = Message(run_t::RESUME);
  context_.telemetry.Send(resume);
  context_.control.ThrowIfToEnd();
  suspension_.RequireSame(last_good_, "a pause");
}

}  // namespace gyrobench::daemon
