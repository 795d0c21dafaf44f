#include "daemon/run_engine.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "base/error.h"
#include "calibration/estimators/plausibility.h"
#include "calibration/estimators/result_json.h"
#include "daemon/bench_facts.h"
#include "daemon/run_record.h"
#include "daemon/run_trace.h"
#include "gyrobench/run_t.hpp"
#include "procedures/engine/engine.h"
#include "recording/run_directory.h"

namespace gyrobench::daemon {
namespace {

// The gyro unit's clock must be known better than the scale factor is to be.
constexpr double kTickFitSpan_s = 20.0;
constexpr Utime kTickFitPatience = 120 * kMicrosecondsPerSecond;
// Samples of the last moment are still in the unit's ring when a run ends.
constexpr Utime kDrain = kMicrosecondsPerSecond / 2;
constexpr Utime kStopPatience = 10 * kMicrosecondsPerSecond;

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

// Everything of one run that its thread needs.
struct RunEngine::Job {
  procedures::Procedure procedure;
  procedures::Parameters parameters;
  procedures::Plan plan;
  std::optional<recording::RunDirectory> directory{};
  std::unique_ptr<Clock::Participant> participant{};
  nlohmann::json description{};
  std::unique_ptr<LiveBench> bench{};
};

RunEngine::RunEngine(Context context)
    : context_(std::move(context)), library_(context_.stand.procedure_dirs) {}

RunEngine::~RunEngine() { Shutdown(); }

std::vector<procedures::AxisFacts> RunEngine::Axes() const {
  std::vector<procedures::AxisFacts> facts;
  for (const config::AxisConfig& axis : context_.stand.axes) {
    facts.push_back(FactsOf(axis, context_.acquisition.Axis(axis.name).reference.angle_deg));
  }
  return facts;
}

procedures::Plan RunEngine::Check(const std::string& procedure,
                                  const procedures::Parameters& parameters) {
  return procedures::DryRun(library_.Find(procedure), parameters, Axes(), DryOptions(), DryHooks());
}

// A dry run is asked for over the control socket, where a stop may be waiting behind it.
procedures::RunHooks RunEngine::DryHooks() {
  procedures::RunHooks hooks;
  hooks.limits.instructions = 50'000'000;
  hooks.limits.processor_s_per_step = 1.0;
  return hooks;
}

procedures::DryOptions RunEngine::DryOptions() const {
  procedures::DryOptions options;
  options.geometry = context_.stand.geometry;
  if (const Outputs* outputs = context_.acquisition.outputs()) {
    for (const auto& [output, on] : outputs->States()) options.outputs.push_back(output);
  }
  const SensorView sensor = context_.acquisition.Sensor();
  if (sensor.identity.gyro_lsb_per_deg_s > 0) {
    options.nominal_scale_deg_s_per_lsb = 1.0 / sensor.identity.gyro_lsb_per_deg_s;
  }
  if (context_.stand.virtual_stand) options.answers = context_.stand.virtual_stand->answers;
  return options;
}

void RunEngine::RequireDevicesWell() const {
  for (const DeviceStatus& device : context_.acquisition.Devices()) {
    if (!device.ok) {
      throw DeviceError(
          fmt::format("{} is not well, so nothing was started: {}", device.name, device.message),
          device.failure);
    }
  }
}

StartedRun RunEngine::Start(const std::string& procedure,
                            const procedures::Parameters& parameters) {
  const std::lock_guard starting(start_mutex_);
  procedures::Procedure found = library_.Find(procedure);
  const procedures::Parameters complete = procedures::CheckParameters(found.info(), parameters);
  procedures::Plan plan = procedures::DryRun(found, complete, Axes(), DryOptions(), DryHooks());
  const auto job = std::make_shared<Job>(Job{std::move(found), complete, std::move(plan)});
  context_.control.RequireReady();
  RequireDevicesWell();
  if (thread_.joinable()) thread_.join();
  job->participant = context_.clock.Join("run");
  context_.control.BeginRun(*job->participant);
  try {
    job->directory =
        recording::RunDirectory::Create(context_.stand.records, procedure, context_.clock.Now());
  } catch (...) {
    context_.control.EndRun();
    throw;
  }
  {
    const std::lock_guard lock(mutex_);
    view_ = RunView{};
    view_->run_id = job->directory->run_id();
    view_->procedure = procedure;
    view_->parameters = job->parameters;
    view_->record = job->directory->folder().string();
    run_start_ = context_.clock.Now();
  }
  const StartedRun started{job->directory->run_id(), job->directory->folder().string(),
                           job->plan.expected_duration_s};
  context_.time.Run();
  thread_ = std::thread([this, job] { Execute(*job); });
  return started;
}

void RunEngine::Shutdown() {
  const std::lock_guard starting(start_mutex_);
  if (!thread_.joinable()) return;
  try {
    context_.control.Abort("aborted because the daemon was told to end");
  } catch (const StateError&) {
    // It has ended, or is ending, by itself.
  }
  thread_.join();
}

void RunEngine::Reset() {
  if (const Outputs* outputs = context_.acquisition.outputs()) {
    for (const auto& [output, on] : outputs->States()) {
      if (on) continue;
      throw StateError(
          fmt::format("the relays do not answer, so nobody knows whether the {} is "
                      "off: see to it by hand, and to the relay unit, first",
                      output));
    }
  }
  context_.control.ClearFault();
  // Holds time until all buses have been told, so that their order is that of the stand file.
  const auto posting = context_.clock.Join("reset");
  context_.acquisition.PostClearAlarms();
  context_.on_fault_cleared();
  context_.on_change();
}

std::optional<RunView> RunEngine::View() const {
  const std::lock_guard lock(mutex_);
  if (!view_) return std::nullopt;
  RunView view = *view_;
  if (view.outcome == Outcome::kNone) {
    view.elapsed_s = ToSeconds(context_.clock.Now() - run_start_);
  }
  return view;
}

void RunEngine::WaitForTickFit(const Job& job) {
  const Utime deadline = context_.clock.Now() + kTickFitPatience;
  for (;;) {
    const double span_s = context_.acquisition.Sensor().tick_span_s;
    if (span_s >= kTickFitSpan_s) return;
    {
      const std::lock_guard lock(mutex_);
      view_->progress.segment = fmt::format("preparing (comparing clocks, {:g} s)", kTickFitSpan_s);
      view_->progress.message = fmt::format(
          "the gyro unit's clock is compared with the host's for {:g} s on end, once after the "
          "daemon's start or a gap in the samples",
          kTickFitSpan_s);
      view_->progress.remaining_s = kTickFitSpan_s - span_s + job.plan.expected_duration_s;
    }
    RequireDevicesWell();
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

void RunEngine::RunProcedureOn(Job& job) {
  context_.acquisition.SetActiveAxes(job.plan.axes);
  WaitForTickFit(job);
  const Utime start = context_.clock.Now();
  {
    const std::lock_guard lock(mutex_);
    run_start_ = start;
    view_->progress = {};
  }
  BeginRecord(job, start);
  job.bench = std::make_unique<LiveBench>(
      LiveBench::Context{context_.stand, context_.clock, *job.participant, context_.acquisition,
                         context_.telemetry, context_.control, job.plan.expected_duration_s,
                         context_.on_configured_answer,
                         [this, &job](bool asking) {
                           if (asking) {
                             context_.time.Idle(*job.participant);
                           } else {
                             context_.time.Run();
                           }
                           context_.on_change();
                           return context_.time.stands_still();
                         },
                         [this](const RunProgress& progress) {
                           const std::lock_guard lock(mutex_);
                           view_->progress = progress;
                         }},
      start);
  procedures::RunProcedure(job.procedure, job.parameters, *job.bench);
}

void RunEngine::BeginRecord(Job& job, Utime start) {
  const MeasurementInfo info = context_.acquisition.Info();
  job.description = DescribeRun(job.directory->run_id(), job.procedure, job.parameters,
                                context_.stand, info, start);
  job.directory->WriteRun(job.description);
  context_.telemetry.BeginRun(job.directory->run_id(), job.directory->EventLog().string(), info,
                              start);
  run_t message{};
  message.utime = start;
  message.event = run_t::START;
  message.procedure = job.procedure.info().name;
  message.record = job.directory->folder().string();
  message.remaining_s = job.plan.expected_duration_s;
  context_.telemetry.Send(message);
}

void RunEngine::WaitForStandstill(Job& job, const std::string& axis) {
  const Utime deadline = context_.clock.Now() + kStopPatience;
  while (context_.acquisition.ReadDriveNow(*job.participant, axis).moving) {
    if (context_.clock.Now() > deadline) {
      throw DeviceError(
          "axis." + axis + ": the drive still moves after a quick stop: use the emergency stop",
          {.device = "axis." + axis, .action = "quick stop"});
    }
    context_.control.Wait(context_.clock, context_.clock.Now() + kMicrosecondsPerSecond / 20);
  }
}

void RunEngine::AddFault(Ending& ending, Fault fault) {
  if (fault.samples.axes.empty()) fault.samples = context_.acquisition.Last();
  context_.on_fault(fault);
  ending.outcome = Outcome::kFault;
  ending.message +=
      fmt::format("{}{}: {}", ending.message.empty() ? "" : "; ", fault.source, fault.message);
  ending.failures.push_back(std::move(fault));
}

// Every axis is tried, whatever the others do.
void RunEngine::StopMotion(Job& job, Ending& ending) {
  Fault failed{"stop", ""};
  const auto attempt = [&failed](const auto& action) {
    try {
      action();
    } catch (const Error& error) {
      AddTo(failed, error);
    }
  };
  attempt([&] { context_.acquisition.StopAll(*job.participant); });
  for (const config::AxisConfig& axis : context_.stand.axes) {
    attempt([&] { WaitForStandstill(job, axis.name); });
  }
  if (!failed.message.empty()) AddFault(ending, std::move(failed));
}

// However a run ends, nothing of the stand heats behind it.
void RunEngine::SwitchOff(Job& job, Ending& ending) {
  Outputs* outputs = context_.acquisition.outputs();
  if (outputs == nullptr) return;
  try {
    outputs->AllOff(*job.participant);
  } catch (const Error& error) {
    AddFault(ending, FaultOf("relays", error));
  }
}

RunEngine::Ending RunEngine::RunToItsEnd(Job& job) {
  Ending ending;
  try {
    RunProcedureOn(job);
    for (const procedures::LimitCheck& check : job.bench->limits()) {
      if (check.passed) continue;
      ending.outcome = Outcome::kFailedLimits;
      ending.message += (ending.message.empty() ? "" : "; ") + procedures::Describe(check);
    }
  } catch (const procedures::Aborted& aborted) {
    return {Outcome::kAborted, aborted.what(), {}};
  } catch (const FaultError& error) {
    Fault fault = error.fault();
    fault.place = error.place();
    AddFault(ending, std::move(fault));
  } catch (const DeviceError& error) {
    AddFault(ending, FaultOf("device", error));
  } catch (const std::exception& error) {
    return {Outcome::kError, error.what(), {FaultOf("procedure", error)}};
  }
  return ending;
}

void RunEngine::Execute(Job& job) {
  Ending ending = RunToItsEnd(job);
  context_.control.BeginStopping();
  context_.time.Run();
  // Nothing heats while the drives are waited for.
  if (Outputs* outputs = context_.acquisition.outputs()) outputs->PostAllOff();
  if (ending.outcome != Outcome::kDone && ending.outcome != Outcome::kFailedLimits) {
    StopMotion(job, ending);
    if (job.bench) ending.message += Reminder(job.bench->on_by_hand());
  }
  SwitchOff(job, ending);
  try {
    Finish(job, ending);
  } catch (const std::exception& error) {
    context_.on_fault(FaultOf("record", error));
  }
  spdlog::info("run {}: {}{}{}", job.directory->run_id(), Name(ending.outcome),
               ending.message.empty() ? "" : ": ", ending.message);
  context_.acquisition.SetActiveAxes({});
  {
    const std::lock_guard lock(mutex_);
    view_->outcome = ending.outcome;
    view_->progress.message = ending.message;
    view_->failures = ending.failures;
    view_->progress.remaining_s = 0.0;
    view_->elapsed_s = ToSeconds(context_.clock.Now() - run_start_);
  }
  // Before the end is known: a run that somebody starts then finds time standing still.
  context_.time.Idle(*job.participant);
  context_.control.EndRun();
  context_.on_change();
  job.participant.reset();
}

void RunEngine::Finish(Job& job, Ending& ending) {
  if (job.description.is_null()) {
    BeginRecord(job, context_.clock.Now());
  } else {
    context_.control.Wait(context_.clock, context_.clock.Now() + kDrain);
  }
  if (job.bench) job.bench->FinishResults();
  context_.telemetry.EndMeasurement();
  const calibration::AnalysisResult results = context_.telemetry.Analyse();
  const Utime end = context_.clock.Now();
  context_.telemetry.SendResults(results, end, true);
  // What ended before its time is not judged by what it did not do.
  const bool complete =
      ending.outcome == Outcome::kDone || ending.outcome == Outcome::kFailedLimits;
  const auto trace =
      complete ? TraceRun(context_.telemetry.Recorded(), TraceFor::kRecord) : std::nullopt;
  if (trace) {
    context_.telemetry.SendTrace(trace->result, end, true);
    context_.telemetry.SendModel(*trace, end, true);
  }
  const std::vector<std::string> implausible = calibration::Implausible(results);
  if (complete && !implausible.empty()) {
    ending.outcome = Outcome::kError;
    ending.message = fmt::format("{}", fmt::join(implausible, "; "));
  }
  run_t stop{};
  stop.utime = end;
  stop.event = run_t::STOP;
  stop.procedure = job.procedure.info().name;
  stop.progress = 1.0;
  stop.outcome = Name(ending.outcome);
  stop.text = ending.message;
  stop.record = job.directory->folder().string();
  context_.telemetry.Send(stop);
  const std::string failure = context_.telemetry.EndRun();
  DescribeEnd(job.description, ending.outcome, ending.message, ending.failures, job.bench.get(),
              end);
  const MeasurementInfo at_end = context_.acquisition.Info();
  DescribePowerOnAtEnd(job.description, at_end.power_on);
  job.directory->WriteResult(calibration::ToJson(results));
  job.directory->WriteRun(job.description);
  if (trace) WriteTrace(*job.directory, job.description, trace->result, results);
  if (!failure.empty()) throw DataError(failure);
}

}  // namespace gyrobench::daemon
