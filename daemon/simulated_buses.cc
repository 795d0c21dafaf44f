#include "daemon/simulated_buses.h"

#include "config/scenario.h"
#include "stand/virtual_stand.h"

namespace gyrobench::daemon {
namespace {

// What is really there.
config::StandConfig WiredAs(const config::StandConfig& config) {
  if (!config.virtual_stand->wired_as) return config;
  config::StandConfig wired = config::LoadStandConfig(*config.virtual_stand->wired_as);
  wired.virtual_stand = config.virtual_stand;
  return wired;
}

class VirtualStandBuses final : public SimulatedBuses {
 public:
  VirtualStandBuses(const config::StandConfig& config, Clock& clock)
      : stand_(WiredAs(config), config::LoadScenario(config.virtual_stand->scenario),
               config.virtual_stand->seed, clock) {
    for (const config::BusConfig& bus : config.buses) buses_.push_back(stand_.Serve(bus));
  }
  std::vector<config::BusConfig> buses() const override { return buses_; }
  void Answered(const std::string& question_id) override {
    if (question_id == "cool") stand_.ColdSoak();
    if (question_id == "fan_on") stand_.SetFan(true);
    if (question_id == "fan_off") stand_.SetFan(false);
    if (question_id == "heater_on") stand_.SetHeater(true);
    if (question_id == "heater_off") stand_.SetHeater(false);
  }

 private:
  stand::VirtualStand stand_;
  std::vector<config::BusConfig> buses_;
};

}  // namespace

std::unique_ptr<SimulatedBuses> MakeSimulatedBuses(const config::StandConfig& stand, Clock& clock) {
  return std::make_unique<VirtualStandBuses>(stand, clock);
}

}  // namespace gyrobench::daemon
