#include "daemon/run_execution.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <set>
#include <utility>

#include "base/error.h"
#include "calibration/estimators/plausibility.h"
#include "calibration/estimators/result_json.h"
#include "daemon/bench_facts.h"
#include "daemon/journal_bench.h"
#include "daemon/run_record.h"
#include "daemon/run_trace.h"
#include "gyrobench/run_t.hpp"
#include "procedures/engine/engine.h"

namespace gyrobench::daemon {
namespace {

// The gyro unit's clock must be known better than the scale factor is to be.
constexpr double kTickFitSpan_s = 20.0;
constexpr Utime kTickFitPatience = 120 * kMicrosecondsPerSecond;
// Samples of the last moment are still in the unit's ring when a run ends.
constexpr Utime kDrain = kMicrosecondsPerSecond / 2;
constexpr double kMostWaitForClock_s = 600.0;

// Of what no program can switch off.
std::string Reminder(const std::set<std::string>& on_by_hand) {
  std::string text;
  for (const std::string& output : on_by_hand) {
    text += fmt::format("; the {} was switched on by hand: switch it off", output);
  }
  return text;
}

}  // namespace

const char* Name(Outcome outcome) {
  switch (outcome) {
    case Outcome::kNone:
      return "";
    case Outcome::kDone:
      return "done";
    case Outcome::kFailedLimits:
      return "failed_limits";
    case Outcome::kAborted:
      return "aborted";
    case Outcome::kFault:
      return "fault";
    case Outcome::kError:
      return "error";
  }
  return "";
}

void RequireDevicesWell(const Acquisition& acquisition) {
  for (const DeviceStatus& device : acquisition.Devices()) {
    if (!device.ok) {
      throw DeviceError(
          fmt::format("{} is not well, so nothing was started: {}", device.name, device.message),
          device.failure);
    }
  }
}

void RequireDevicesAnswer(const Acquisition& acquisition) {
  for (const DeviceStatus& device : acquisition.Devices()) {
    if (device.ok || device.failure.code_kind != DeviceFailure::CodeKind::kSystemError) continue;
    throw DeviceError(
        fmt::format("{} does not answer, so nothing was started: {}. What answers on the "
                    "lines: gyrobench devices, without the daemon",
                    device.name, device.message),
        device.failure);
  }
}

RunExecution::RunExecution(const RunContext& context, procedures::Procedure procedure,
                           procedures::Parameters parameters, procedures::Plan plan,
                           recording::RunDirectory directory,
                           std::unique_ptr<Clock::Participant> participant,
                           std::optional<ResumedRun> resumed)
    : context_(context),
      procedure_(std::move(procedure)),
      parameters_(std::move(parameters)),
      plan_(std::move(plan)),
      directory_(std::move(directory)),
      participant_(std::move(participant)),
      resumed_(std::move(resumed)),
      start_(context.clock.Now()) {
  view_.run_id = directory_.run_id();
  view_.procedure = procedure_.info().name;
  view_.parameters = parameters_;
  view_.record = directory_.folder().string();
}

RunView RunExecution::View() const {
  const std::lock_guard lock(mutex_);
  RunView view = view_;
  if (view.outcome == Outcome::kNone) view.elapsed_s = ToSeconds(context_.clock.Now() - start_);
  return view;
}

void RunExecution::WaitForTickFit() {
  const Utime deadline = context_.clock.Now() + kTickFitPatience;
  for (;;) {
    const double span_s = context_.acquisition.Sensor().tick_span_s;
    if (span_s >= kTickFitSpan_s) return;
    {
      const std::lock_guard lock(mutex_);
      view_.progress.segment = fmt::format("preparing (comparing clocks, {:g} s)", kTickFitSpan_s);
      view_.progress.message = fmt::format(
          "the gyro unit's clock is compared with the host's for {:g} s on end, once after the "
          "daemon's start or a gap in the samples",
          kTickFitSpan_s);
      view_.progress.remaining_s = kTickFitSpan_s - span_s + plan_.expected_duration_s;
    }
    RequireDevicesWell(context_.acquisition);
    if (context_.clock.Now() > deadline) {
      throw FaultError({"gyro",
                        fmt::format("its clock could not be compared with the host's for {:g} s "
                                    "on end within {:g} s",
                                    kTickFitSpan_s, ToSeconds(kTickFitPatience)),
                        {.device = "gyro", .action = "compare clocks"}});
    }
    context_.control.Wait(context_.clock, context_.clock.Now() + kMicrosecondsPerSecond);
  }
}

void RunExecution::RunProcedure() {
  // Soft limits by a file that may be wrong guard nothing.
  if (!procedure_.info().commissions) context_.acquisition.SetActiveAxes(plan_.axes);
  if (!procedure_.info().commissions) WaitForTickFit();
  if (resumed_) WaitForEarlierEnd();
  context_.control.Prepared();
  const Utime start = BeginOfMeasurement();
  {
    const std::lock_guard lock(mutex_);
    start_ = start;
    view_.progress = {};
  }
  const SensorView sensor = context_.acquisition.Sensor();
  missed_before_ = sensor.missed;
  starts_before_ = sensor.starts;
  BeginRecord(start);
  spdlog::info("run {}: {}", directory_.run_id(), resumed_ ? "goes on" : "begun");
  MakeBench(start);
  try {
    RunScript();
  } catch (const procedures::Aborted&) {  // in the middle of the script, which does not know why
    context_.control.ThrowIfToEnd();
    throw;
  }
}

void RunExecution::MakeBench(Utime start) {
  bench_ = std::make_unique<LiveBench>(
      LiveBench::Context{context_.stand, context_.clock, *participant_, context_.acquisition,
                         context_.telemetry, context_.control, plan_.expected_duration_s,
                         context_.on_configured_answer,
                         [this](bool asking) {
                           if (asking) {
                             context_.time.Idle(*participant_);
                           } else {
                             context_.time.Run();
                           }
                           context_.on_change();
                           return context_.time.stands_still();
                         },
                         [this](const RunProgress& progress) {
                           const std::lock_guard lock(mutex_);
                           view_.progress = progress;
                         },
                         procedure_.info().commissions},
      start);
}

void RunExecution::RunScript() {
  procedures::RunHooks hooks;
  hooks.limits.cancelled = [this] { return context_.control.IsToEnd(); };
  if (!procedure_.info().resumable) {
    procedures::RunProcedure(procedure_, parameters_, *bench_, hooks);
    return;
  }
  JournalBench bench({*bench_, [this](const FinishedCommand& command) { bench_->Record(command); },
                      [this] { bench_->TakeUp(*resumed_); }},
                     resumed_ ? resumed_->journal : std::vector<FinishedCommand>());
  procedures::RunProcedure(procedure_, parameters_, bench, hooks);
}

// Times of one record go forward: on the virtual stand bench time may be ahead of the wall clock
// from which the next daemon counts, on a bench the wall clock may have been set back.
void RunExecution::WaitForEarlierEnd() {
  const Utime until = resumed_->end + kMicrosecondsPerSecond;
  const double wait_s = ToSeconds(until - context_.clock.Now());
  if (!context_.stand.virtual_stand && wait_s > kMostWaitForClock_s) {
    throw Error(
        fmt::format("this machine's clock is {:.0f} s behind the end of run {}: set it "
                    "right, and start the daemon again",
                    wait_s, resumed_->from.run_id()));
  }
  if (wait_s > 0) context_.control.Wait(context_.clock, until);
}

Utime RunExecution::BeginOfMeasurement() const {
  return resumed_ ? resumed_->start : context_.clock.Now();
}

void RunExecution::BeginRecord(Utime start) {
  MeasurementInfo info = context_.acquisition.Info();
  power_on_at_begin_ = info.power_on;
  std::function<bool(AnyMessage&)> earlier;
  if (resumed_) {
    const bool same = IsSamePowerOn(*resumed_, info, context_.stand.virtual_stand.has_value());
    info = ContinuedInfo(*resumed_, info, same);
    earlier = MessagesBefore(*resumed_, same);
  }
  description_ =
      DescribeRun(directory_.run_id(), procedure_, parameters_, context_.stand, info, start);
  if (resumed_) DescribeResumption(description_, *resumed_, directory_.run_id());
  directory_.WriteRun(description_);
  context_.telemetry.BeginRun(directory_.run_id(), directory_.EventLog().string(), info, start,
                              earlier);
  run_t message{};
  message.utime = resumed_ ? context_.clock.Now() : start;
  message.event = run_t::START;
  message.procedure = procedure_.info().name;
  message.record = directory_.folder().string();
  message.remaining_s = plan_.expected_duration_s;
  context_.telemetry.Send(message);
}

RunExecution::Ending RunExecution::RunToItsEnd() {
  Ending ending;
  try {
    RunProcedure();
    for (const procedures::LimitCheck& check : bench_->limits()) {
      if (check.passed) continue;
      ending.outcome = Outcome::kFailedLimits;
      ending.Say(procedures::Describe(check));
    }
  } catch (const procedures::Aborted& aborted) {
    return {Outcome::kAborted, aborted.what(), {}};
  } catch (const FaultError& error) {
    Fault fault = error.fault();
    fault.place = error.place();
    AddFault(ending, std::move(fault));
  } catch (const DeviceError& error) {
    AddFault(ending, FaultOfDevice(error));
  } catch (const std::exception& error) {
    return {Outcome::kError, error.what(), {FaultOf("procedure", error)}};
  }
  return ending;
}

void RunExecution::Execute() {
  context_.time.Run();
  Ending ending = RunToItsEnd();
  context_.control.BeginStopping();
  context_.time.Run();
  // Nothing heats while the drives are waited for.
  if (Outputs* outputs = context_.acquisition.outputs()) outputs->PostAllOff();
  if (!ending.came_to_its_end()) {
    StopMotion(ending);
    if (bench_) ending.message += Reminder(bench_->on_by_hand());
  }
  SwitchOff(ending);
  if (const std::vector<std::string> left = HowItIs(context_.acquisition);
      !ending.failures.empty()) {
    for (Fault& failure : ending.failures) failure.left = left;
    context_.control.SetLeft(left);
  }
  Attempt(ending, [&] { Finish(ending); });
  spdlog::info("run {}: {}{}{}", directory_.run_id(), Name(ending.outcome),
               ending.message.empty() ? "" : ": ", ending.message);
  context_.acquisition.SetActiveAxes({});
  // Before the end is known: a run that somebody starts then finds time standing still.
  context_.time.Idle(*participant_);
  End(ending);
  context_.on_change();
  participant_.reset();
}

void RunExecution::End(const Ending& ending) {
  const std::lock_guard lock(mutex_);
  view_.outcome = ending.outcome;
  view_.progress.message = ending.message;
  view_.failures = ending.failures;
  view_.progress.remaining_s = 0.0;
  view_.elapsed_s = ToSeconds(context_.clock.Now() - start_);
  context_.control.EndRun();
}

void RunExecution::Attempt(Ending& ending, const std::function<void()>& part) {
  try {
    part();
  } catch (const std::exception& error) {  // a run without its record is not done
    AddFault(ending, FaultOf("record", error));
  }
}

void RunExecution::Finish(Ending& ending) {
  Attempt(ending, [&] {
    if (description_.is_null()) {
      BeginRecord(BeginOfMeasurement());
    } else {
      context_.control.Wait(context_.clock, context_.clock.Now() + kDrain);
    }
  });
  if (bench_) Attempt(ending, [&] { bench_->FinishResults(); });
  context_.telemetry.EndMeasurement();
  // Of the record, or on the way here: a fault is no end of a run that is done.
  context_.telemetry.Sync();
  if (const auto fault = context_.control.fault(); fault && ending.failures.empty()) {
    AddFault(ending, *fault);
  }
  const Utime end = context_.clock.Now();
  TellOfSuspensions(ending);
  if (!procedure_.info().commissions) TellOfGyro(ending);
  const Results results = Evaluate(ending, end);
  run_t stop{};
  stop.utime = end;
  stop.event = run_t::STOP;
  stop.procedure = procedure_.info().name;
  stop.progress = 1.0;
  stop.outcome = Name(ending.outcome);
  stop.text = ending.message;
  stop.record = directory_.folder().string();
  Attempt(ending, [&] { context_.telemetry.RecordOnly(stop); });
  Attempt(ending, [&] {
    if (const std::string failure = context_.telemetry.EndRun(); !failure.empty()) {
      throw DataError(failure);
    }
  });
  WriteFiles(ending, results, end);
  // Last, so that nobody hears of a run that is done before its record is whole.
  stop.outcome = Name(ending.outcome);
  stop.text = ending.message;
  Attempt(ending, [&] { context_.telemetry.PublishOnly(stop); });
}

RunExecution::Results RunExecution::Evaluate(Ending& ending, Utime end) {
  Results results;
  if (procedure_.info().commissions) return results;
  Attempt(ending, [&] {
    results.analysis = context_.telemetry.Analyse();
    context_.telemetry.SendResults(results.analysis, end, true);
  });
  // What ended before its time is not judged by what it did not do.
  if (!ending.came_to_its_end()) return results;
  Attempt(ending, [&] {
    results.trace = TraceRun(context_.telemetry.Recorded(), TraceFor::kRecord);
    if (!results.trace) return;
    for (const calibration::Contradiction& one : calibration::Contradictions(results.analysis))
      calibration::Condemn(one.axes, one.says, &results.trace->result);
    context_.telemetry.SendTrace(results.trace->result, end, true);
    context_.telemetry.SendModel(*results.trace, end, true);
  });
  const std::vector<std::string> implausible = calibration::Implausible(results.analysis);
  if (ending.failures.empty() && !implausible.empty()) {
    ending.outcome = Outcome::kError;
    const std::string before = std::exchange(ending.message, "");
    ending.Say(fmt::format("{}", fmt::join(implausible, "; ")));
    if (!before.empty()) ending.Say(before);
  }
  return results;
}

void RunExecution::WriteFiles(Ending& ending, const Results& results, Utime end) {
  const auto write_run = [&] {
    DescribeEnd(description_, ending.outcome, ending.message, ending.failures, bench_.get(), end);
    if (const std::string power_on = context_.acquisition.Info().power_on;
        power_on != power_on_at_begin_)
      DescribePowerOnAtEnd(description_, power_on);
    directory_.WriteRun(description_);
  };
  if (!procedure_.info().commissions)
    Attempt(ending, [&] { directory_.WriteResult(calibration::ToJson(results.analysis)); });
  Attempt(ending, write_run);
  if (!results.trace) return;
  const std::size_t failures = ending.failures.size();
  Attempt(ending,
          [&] { WriteTrace(directory_, description_, results.trace->result, results.analysis); });
  if (ending.failures.size() > failures) Attempt(ending, write_run);
}

}  // namespace gyrobench::daemon
