#include "daemon/outputs.h"

#include <fmt/format.h>

#include <utility>

#include "base/error.h"

namespace gyrobench::daemon {

Outputs::Outputs(const config::RelaysConfig& config, BusWorker& worker,
                 std::unique_ptr<drivers::Relays> relays, FaultHandler on_fault)
    : config_(config), worker_(worker), on_fault_(std::move(on_fault)), relays_(std::move(relays)) {
  for (const auto& [output, channel] : config.channels) on_[output] = false;
}

void Outputs::Open() {
  relays_->Open();
  for (const auto& [output, channel] : config_.channels) Note(output, false);
}

void Outputs::Check() { relays_->Check(); }

void Outputs::Note(const std::string& output, bool on) {
  const std::lock_guard lock(mutex_);
  on_[output] = on;
  if (output == "heater" && !on) too_hot_ = false;
}

std::map<std::string, bool> Outputs::States() const {
  const std::lock_guard lock(mutex_);
  return on_;
}

// What was to be on counts as on, whether the unit has answered or not.
void Outputs::SwitchHere(const std::string& output, bool on) {
  if (on) Note(output, true);
  relays_->Switch(output, on);
  Note(output, on);
}

void Outputs::Switch(Clock::Participant& caller, const std::string& output, bool on) {
  worker_.Call(caller, [&] { SwitchHere(output, on); });
}

void Outputs::AllOff(Clock::Participant& caller) {
  std::string failures;
  for (const auto& [output, on] : States()) {
    if (!on) continue;
    try {
      Switch(caller, output, false);
    } catch (const Error& error) {
      failures += fmt::format("{}{} cannot be switched off: {}", failures.empty() ? "" : "; ",
                              output, error.what());
    }
  }
  if (!failures.empty()) throw DeviceError(failures);
}

void Outputs::Watch(double temperature_degC) {
  {
    const std::lock_guard lock(mutex_);
    const auto heater = on_.find("heater");
    if (heater == on_.end() || !heater->second || too_hot_) return;
    if (temperature_degC <= config_.heater_max_degC) return;
    too_hot_ = true;
  }
  for (const auto& [output, channel] : config_.channels) {
    worker_.Post([this, name = output] {
      try {
        SwitchHere(name, false);
      } catch (const std::exception& error) {
        on_fault_("relays", error.what());
      }
    });
  }
  on_fault_("relays", fmt::format("the gyro's thermometer says {:.1f} degC with the heater on, "
                                  "heater_max_degC = {:g}: everything was switched off. Let it "
                                  "cool, or correct the limit, then: gyrobench reset",
                                  temperature_degC, config_.heater_max_degC));
}

}  // namespace gyrobench::daemon
