#include "daemon/run_engine.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "base/error.h"
#include "daemon/bench_facts.h"
#include "daemon/disk_room.h"
#include "procedures/engine/engine.h"

namespace gyrobench::daemon {

RunEngine::RunEngine(Context context)
    : context_(std::move(context)), library_(context_.stand.procedure_dirs, LoadLimits()) {}

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
  return DryRunUntil(std::nullopt, library_.Find(procedure), parameters, Axes());
}

// Bounded, since whoever asks for a dry run or a list waits for it.
procedures::SandboxLimits RunEngine::LoadLimits() const {
  procedures::SandboxLimits limits;
  limits.instructions = 50'000'000;
  limits.processor_s_per_step = 1.0;
  limits.processor_s = 20.0;
  limits.cancelled = [this] { return context_.control.stopped_for_good(); };
  return limits;
}

procedures::Plan RunEngine::DryRunUntil(std::optional<std::int64_t> stops,
                                        const procedures::Procedure& procedure,
                                        const procedures::Parameters& parameters,
                                        const std::vector<procedures::AxisFacts>& axes) const {
  procedures::RunHooks hooks;
  hooks.limits = LoadLimits();
  hooks.limits.cancelled = [this, stops] {
    return context_.control.stopped_for_good() || (stops && *stops != context_.control.stops());
  };
  try {
    return procedures::DryRun(procedure, parameters, axes, DryOptions(), hooks);
  } catch (const procedures::Aborted&) {
    throw StateError("stopped while the procedure was run dry: nothing has moved");
  }
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

StartedRun RunEngine::Start(const std::string& procedure, const procedures::Parameters& parameters,
                            std::optional<std::int64_t> asked_at) {
  const std::int64_t stops = asked_at.value_or(context_.control.stops());
  const std::lock_guard starting(start_mutex_);
  procedures::Procedure found = library_.Find(procedure);
  procedures::Parameters complete = procedures::CheckParameters(found.info(), parameters);
  procedures::Plan plan = DryRunUntil(stops, found, complete, Axes());
  return Begin(stops, std::move(found), std::move(complete), std::move(plan));
}

StartedRun RunEngine::Resume(const std::string& run_id, std::optional<std::int64_t> asked_at) {
  const std::int64_t stops = asked_at.value_or(context_.control.stops());
  const std::lock_guard starting(start_mutex_);
  context_.control.RequireReady();
  ResumedRun resumed = ReadInterrupted(context_.stand.records, run_id);
  procedures::Procedure found = library_.Find(resumed.description.value("procedure", ""));
  RequireDevicesWell(context_.acquisition);
  RequireSame(resumed, found, context_.stand, context_.acquisition.Info());
  std::vector<procedures::AxisFacts> axes = Axes();
  for (procedures::AxisFacts& axis : axes) axis.angle_deg = resumed.begin_angles_deg.at(axis.name);
  procedures::Parameters complete = procedures::CheckParameters(found.info(), resumed.parameters);
  procedures::Plan plan = DryRunUntil(stops, found, complete, axes);
  return Begin(stops, std::move(found), std::move(complete), std::move(plan), std::move(resumed));
}

StartedRun RunEngine::Begin(std::int64_t stops, procedures::Procedure procedure,
                            procedures::Parameters parameters, procedures::Plan plan,
                            std::optional<ResumedRun> resumed) {
  const double duration_s = plan.expected_duration_s;
  context_.control.RequireReady();
  if (std::string low = WhyNoRoom(context_.stand.records, context_.stand.safety.min_free_mib);
      !low.empty()) {
    throw DataError("nothing was started: " + low);
  }
  const bool commissions = procedure.info().commissions;
  if (commissions) {
    RequireDevicesAnswer(context_.acquisition);
  } else {
    RequireDevicesWell(context_.acquisition);
  }
  if (thread_.joinable()) thread_.join();
  auto participant = context_.clock.Join("run");
  using enum RunControl::Devices;
  context_.control.BeginRun(*participant, stops, commissions ? kMayBeUnwell : kMustBeWell);
  const RunView view = Launch(std::move(procedure), std::move(parameters), std::move(plan),
                              std::move(participant), std::move(resumed));
  return {view.run_id, view.record, duration_s};
}

RunView RunEngine::Launch(procedures::Procedure procedure, procedures::Parameters parameters,
                          procedures::Plan plan, std::unique_ptr<Clock::Participant> participant,
                          std::optional<ResumedRun> resumed) {
  std::shared_ptr<RunExecution> run;
  try {
    // Once more: what fell silent before the run was on was told to nobody.
    if (!procedure.info().commissions) RequireDevicesWell(context_.acquisition);
    auto directory = recording::RunDirectory::Create(context_.stand.records, procedure.info().name,
                                                     context_.clock.Now());
    run = std::make_shared<RunExecution>(context_, std::move(procedure), std::move(parameters),
                                         std::move(plan), std::move(directory),
                                         std::move(participant), std::move(resumed));
    RunView view = run->View();  // as it begins
    const std::lock_guard lock(mutex_);
    thread_ = std::thread([run] { run->Execute(); });
    last_ = std::move(run);
    return view;
  } catch (const std::system_error& error) {
    context_.control.EndRun();
    throw Error(
        fmt::format("the run got no thread of its own, and nothing has moved: {}. See what "
                    "else runs on this machine",
                    error.what()));
  } catch (...) {
    context_.control.EndRun();
    throw;
  }
}

void RunEngine::PostStop() {
  // Holds time until all buses have been told, so that their order is that of the stand file.
  const auto posting = context_.clock.Join("stop");
  context_.acquisition.PostStopAll();
  if (Outputs* outputs = context_.acquisition.outputs()) outputs->PostAllOff();
}

void RunEngine::Stop(const std::string& reason) {
  // The run first, so that no move of its can queue up behind the stop.
  context_.control.Stop(reason);
  PostStop();
}

void RunEngine::StopForGood(const std::string& reason) {
  context_.control.StopForGood(reason);
  PostStop();
}

void RunEngine::Shutdown() {
  StopForGood("aborted because the daemon was told to end");
  const std::lock_guard starting(start_mutex_);
  if (thread_.joinable()) thread_.join();
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
  // Before anything is told to the buses, whose answer may be the next fault.
  context_.clear_fault();
  // Holds time until all buses have been told, so that their order is that of the stand file.
  const auto posting = context_.clock.Join("reset");
  context_.acquisition.PostRearm();
  context_.acquisition.PostClearAlarms();
  context_.on_change();
}

std::optional<RunView> RunEngine::View() const {
  std::shared_ptr<RunExecution> last;
  {
    const std::lock_guard lock(mutex_);
    last = last_;
  }
  return last ? std::optional(last->View()) : std::nullopt;
}

}  // namespace gyrobench::daemon
