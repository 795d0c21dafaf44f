#include "daemon/outputs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "base/error.h"

namespace gyrobench::daemon {
namespace {

// Of the request itself, whose own tries a stop that waits for the line cuts short.
constexpr int kOffTries = 3;

}  // namespace

Outputs::Outputs(const config::RelaysConfig& config, BusWorker& worker,
                 std::unique_ptr<drivers::Relays> relays, FaultHandler on_fault)
    : config_(config), worker_(worker), on_fault_(std::move(on_fault)), relays_(std::move(relays)) {
  for (const auto& [output, channel] : config.channels) wanted_[output] = false;
}

void Outputs::Open() {
  {
    const std::lock_guard lock(mutex_);
    answers_ = false;
    for (auto& [output, on] : wanted_) on = false;
  }
  relays_->Open();
  const std::lock_guard lock(mutex_);
  answers_ = true;
  too_hot_ = false;
}

void Outputs::Check() {
  try {
    Compare(relays_->Read());
  } catch (const Error&) {
    const std::lock_guard lock(mutex_);
    answers_ = false;
    throw;
  }
  const std::lock_guard lock(mutex_);
  answers_ = true;
}

void Outputs::Compare(const std::map<std::string, bool>& found) {
  std::map<std::string, bool> wanted;
  {
    const std::lock_guard lock(mutex_);
    wanted = wanted_;
  }
  for (const auto& [output, on] : found) {
    if (on == wanted.at(output)) continue;
    SwitchOffHere(output);
    on_fault_({"relays",
               fmt::format("{} was switched {} and was found {}: switched off. Was the relay unit "
                           "restarted, or does somebody else switch it? Then: gyrobench reset",
                           output, wanted.at(output) ? "on" : "off", on ? "on" : "off"),
               {.device = "relays", .action = output}});
  }
}

std::map<std::string, std::optional<bool>> Outputs::States() const {
  const std::lock_guard lock(mutex_);
  std::map<std::string, std::optional<bool>> states;
  for (const auto& [output, on] : wanted_) {
    states[output] = answers_ ? std::optional<bool>(on) : std::nullopt;
  }
  return states;
}

void Outputs::SwitchHere(const std::string& output, bool on) {
  {
    const std::lock_guard lock(mutex_);
    if (wanted_.contains(output)) wanted_[output] = on;
  }
  relays_->Switch(output, on);
  const std::lock_guard lock(mutex_);
  if (output == "heater" && !on) too_hot_ = false;
}

void Outputs::SwitchOffHere(const std::string& output) {
  for (int tries = 1;; ++tries) {
    try {
      SwitchHere(output, false);
      return;
    } catch (const DeviceError&) {
      if (tries == kOffTries) throw;
      worker_.LetUrgentPass();
    }
  }
}

void Outputs::Switch(Clock::Participant& caller, const std::string& output, bool on,
                     const std::function<void()>& may_switch) {
  try {
    worker_.Call(caller, [&] {
      may_switch();
      if (on) {
        SwitchHere(output, true);
      } else {
        SwitchOffHere(output);
      }
    });
  } catch (const DeviceError& error) {
    PostAllOff();
    may_switch();
    throw FaultError(FaultOf("relays", error));
  }
}

std::optional<Fault> Outputs::TryAllOff() {
  struct Failed {
    std::vector<std::string> outputs;  // for the same reason
    Fault why;
  };
  std::vector<Failed> all;
  for (auto it = config_.channels.rbegin(); it != config_.channels.rend(); ++it) {
    const std::string& output = it->first;
    worker_.LetUrgentPass();
    try {
      SwitchOffHere(output);
    } catch (const Error& error) {
      const Fault why = FaultOf("relays", error);
      const auto alike = std::ranges::find_if(
          all, [&why](const Failed& before) { return HaveSameCause(before.why, why); });
      if (alike != all.end()) {
        alike->outputs.push_back(output);
      } else {
        all.push_back({{output}, why});
      }
    }
  }
  if (all.empty()) return std::nullopt;
  Fault fault{"relays", ""};
  for (const Failed& failed : all) {
    AddTo(fault,
          DeviceError(fmt::format("the {} cannot be switched off, disconnect {} by hand: {}",
                                  fmt::join(failed.outputs, " and the "),
                                  failed.outputs.size() > 1 ? "them" : "it", failed.why.message),
                      failed.why.failure));
  }
  return fault;
}

void Outputs::PostAllOff() {
  worker_.PostOnce("outputs off", [this] {
    if (const auto fault = TryAllOff()) on_fault_(*fault);
  });
}

void Outputs::AllOff(Clock::Participant& caller) {
  const auto fault = worker_.Call(caller, [this] { return TryAllOff(); });
  if (fault) throw DeviceError(fault->message, fault->failure);
}

void Outputs::Watch(double temperature_degC) {
  {
    const std::lock_guard lock(mutex_);
    const auto heater = wanted_.find("heater");
    if (heater == wanted_.end() || !heater->second || too_hot_) return;
    if (temperature_degC <= config_.heater_max_degC) return;
    too_hot_ = true;
  }
  // Reported once it is known what became of it, and before anything else can be switched.
  worker_.Post([this, temperature_degC] {
    const auto fault = TryAllOff();
    on_fault_({"relays",
               fmt::format("the gyro's thermometer says {:.1f} degC with the heater on, "
                           "heater_max_degC = {:g}: {}. Let it cool, or correct the limit, then: "
                           "gyrobench reset",
                           temperature_degC, config_.heater_max_degC,
                           fault ? fault->message : "everything was switched off"),
               fault ? fault->failure : DeviceFailure{.device = "relays", .action = "heater"}});
  });
}

}  // namespace gyrobench::daemon
