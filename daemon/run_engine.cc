#include "daemon/run_engine.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"
#include "daemon/bench_facts.h"
#include "procedures/engine/engine.h"

namespace gyrobench::daemon {

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

StartedRun RunEngine::Start(const std::string& procedure,
                            const procedures::Parameters& parameters) {
  const std::lock_guard starting(start_mutex_);
  procedures::Procedure found = library_.Find(procedure);
  procedures::Parameters complete = procedures::CheckParameters(found.info(), parameters);
  procedures::Plan plan = procedures::DryRun(found, complete, Axes(), DryOptions(), DryHooks());
  const double duration_s = plan.expected_duration_s;
  context_.control.RequireReady();
  RequireDevicesWell(context_.acquisition);
  if (thread_.joinable()) thread_.join();
  auto participant = context_.clock.Join("run");
  context_.control.BeginRun(*participant);
  try {
    auto directory =
        recording::RunDirectory::Create(context_.stand.records, procedure, context_.clock.Now());
    const std::lock_guard lock(mutex_);
    last_ = std::make_shared<RunExecution>(context_, std::move(found), std::move(complete),
                                           std::move(plan), std::move(directory),
                                           std::move(participant));
  } catch (...) {
    context_.control.EndRun();
    throw;
  }
  const RunView view = last_->View();
  context_.time.Run();
  thread_ = std::thread([run = last_] { run->Execute(); });
  return {view.run_id, view.record, duration_s};
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
  std::shared_ptr<RunExecution> last;
  {
    const std::lock_guard lock(mutex_);
    last = last_;
  }
  return last ? std::optional(last->View()) : std::nullopt;
}

}  // namespace gyrobench::daemon
