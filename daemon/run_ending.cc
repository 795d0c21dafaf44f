// What is stopped, switched off and said at the end of a run.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "daemon/polled_device.h"
#include "daemon/run_execution.h"

namespace gyrobench::daemon {
namespace {

constexpr Utime kStopPatience = 10 * kMicrosecondsPerSecond;
constexpr const char* kSameReason = "for the same reason";

std::string Times(int count) { return count == 1 ? "once" : fmt::format("{} times", count); }

// What could not be stopped, and why; a reason that was told is not told again.
class NotStopped {
 public:
  explicit NotStopped(const std::vector<Fault>& told) : told_(told) {}
  void Add(Fault fault) {
    const bool told = std::ranges::any_of(
        told_, [&fault](const Fault& before) { return HaveSameCause(before, fault); });
    told_.push_back(fault);
    if (told && !fault.failure.device.empty()) {
      fault.message =
          fmt::format("{}: {}: {}", fault.failure.device, fault.failure.action, kSameReason);
    }
    AddTo(all_, DeviceError(fault.message, fault.failure));
  }
  const Fault& all() const { return all_; }

 private:
  std::vector<Fault> told_;
  Fault all_{"stop", ""};
};

}  // namespace

// A drive that is no longer enabled does not move the axis.
void RunExecution::WaitForStandstill(const std::string& axis) try {
  const Utime deadline = context_.clock.Now() + kStopPatience;
  while (context_.acquisition.ReadDriveNow(*participant_, axis).moving) {
    if (context_.clock.Now() > deadline) {
      throw DeviceError(
          "axis." + axis + ": the drive still moves after a quick stop: use the emergency stop",
          {.device = "axis." + axis, .action = "quick stop"});
    }
    context_.control.Wait(context_.clock, context_.clock.Now() + kMicrosecondsPerSecond / 20);
  }
} catch (const MustBeOpenedAgain&) {
}

void RunExecution::AddFault(Ending& ending, Fault fault) {
  if (fault.samples.axes.empty()) fault.samples = context_.acquisition.Last();
  context_.on_fault(fault);
  ending.outcome = Outcome::kFault;
  std::string text = TextOf(fault);
  for (const Fault& told : ending.failures) {
    const std::size_t place = told.message.empty() ? std::string::npos : text.find(told.message);
    if (place != std::string::npos) text.replace(place, told.message.size(), kSameReason);
  }
  ending.Say(text);
  ending.failures.push_back(std::move(fault));
}

// Every axis is tried, whatever the others do.
void RunExecution::StopMotion(Ending& ending) {
  NotStopped failed(ending.failures);
  for (Fault& fault : context_.acquisition.TryStopAll(*participant_)) failed.Add(std::move(fault));
  for (const config::AxisConfig& axis : context_.stand.axes) {
    try {
      WaitForStandstill(axis.name);
    } catch (const Error& error) {
      failed.Add(FaultOf("axis." + axis.name, error));
    }
  }
  if (failed.all().message.empty()) return;
  Fault fault = failed.all();
  fault.message = "an axis may not have been stopped: " + fault.message;
  AddFault(ending, std::move(fault));
}

// However a run ends, nothing of the stand heats behind it.
void RunExecution::SwitchOff(Ending& ending) {
  Outputs* outputs = context_.acquisition.outputs();
  if (outputs == nullptr) return;
  try {
    outputs->AllOff(*participant_);
  } catch (const Error& error) {
    AddFault(ending, FaultOf("relays", error));
  }
}

void RunExecution::TellOfSuspensions(Ending& ending) const {
  if (!bench_ || bench_->suspensions().count == 0) return;
  const LiveBench::Suspensions& all = bench_->suspensions();
  ending.Say(fmt::format("the run was suspended {}, for {:.1f} s in all ({} did not answer)",
                         Times(all.count), all.duration_s, fmt::join(all.devices, ", ")));
}

// A daemon that the machine starved, a bus that is too slow, a supply that broke down for a moment:
// the run may be as good, and is marked.
void RunExecution::TellOfGyro(Ending& ending) {
  const auto tell = [&](const std::string& text) {
    ending.Say(text);
    if (bench_) Attempt(ending, [&] { bench_->Say(text); });
  };
  const SensorView sensor = context_.acquisition.Sensor();
  if (const int starts = sensor.starts - starts_before_; starts > 0) {
    tell(fmt::format(
        "the gyro's unit started anew within the run ({}), and its zero-rate offset may be "
        "another one since. Look at its supply, and measure again",
        Times(starts)));
  }
  if (const std::int64_t lost = sensor.missed - missed_before_; lost > 0) {
    tell(fmt::format(
        "{} samples of the gyro were lost: its unit overwrote them before they were read. "
        "Was the daemon kept from running, or the unit silent?",
        lost));
  }
}

}  // namespace gyrobench::daemon
