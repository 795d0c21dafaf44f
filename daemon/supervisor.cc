#include "daemon/supervisor.h"

#include <spdlog/spdlog.h>

#include <optional>
#include <utility>

#include "daemon/bench_facts.h"
#include "gyrobench/fault_t.hpp"

namespace gyrobench::daemon {

void Supervisor::Report(const Fault& fault) {
  const std::lock_guard lock(mutex_);
  // What stopped a run is reported by who found it, and once more at the run's end.
  if (context_.control.Report(fault)) spdlog::error("fault: {}", TextOf(fault));
  // Within a run, once all is stopped.
  if (!context_.control.run_is_on() && acquisition_ != nullptr) {
    context_.control.SetLeft(HowItIs(*acquisition_));
  }
  if (!std::exchange(announced_, true)) {
    AnnounceLocked(true, context_.control.fault().value_or(fault));
  }
}

void Supervisor::FellSilent(const Fault& fault) {
  if (!context_.control.run_is_on()) return;
  const bool waits =
      fault.may_pass && fault.source != "relays" && context_.stand.safety.resume_within_s > 0;
  // First, so that nothing that moves or heats can queue up behind what follows.
  const bool suspended = waits && context_.control.Suspend(fault);
  acquisition_->PostStopWhatAnswers();
  if (Outputs* outputs = acquisition_->outputs()) outputs->PostAllOff();
  if (!suspended) return Report(fault);
  spdlog::warn("run suspended: {}", TextOf(fault));
  context_.on_change();
}

void Supervisor::ClearFault() {
  const std::lock_guard lock(mutex_);
  const std::optional<Fault> cleared = context_.control.fault();
  context_.control.ClearFault();
  if (std::exchange(announced_, false)) AnnounceLocked(false, cleared.value_or(Fault{}));
}

void Supervisor::AnnounceLocked(bool active, const Fault& fault) {
  fault_t event{};
  event.utime = context_.clock.Now();
  event.active = active;
  event.source = fault.source;
  event.message = fault.message;
  context_.telemetry.Send(event);
  context_.on_change();
}

}  // namespace gyrobench::daemon
