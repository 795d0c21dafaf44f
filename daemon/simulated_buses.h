// The seam between the daemon and the simulation.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/clock.h"
#include "config/stand_config.h"

namespace gyrobench::daemon {

// A virtual stand that serves all buses of `stand` while it lives.
class SimulatedBuses {
 public:
  virtual ~SimulatedBuses() = default;
  // The buses that the drivers are to use in place of those of the stand file.
  virtual std::vector<config::BusConfig> buses() const = 0;
  // The stand file has answered a question in the operator's place: what the operator would have
  // done by hand happens (`cool`: the gyro unit is brought to the scenario's start temperature;
  // `fan_on`, `fan_off`, `heater_on`, `heater_off`).
  virtual void Answered(const std::string& question_id) = 0;
};

// For a stand file with a [virtual] table. Throws ConfigError for a bad scenario, and in a daemon
// that was built without the virtual stand (CMake option GYROBENCH_VIRTUAL_STAND).
std::unique_ptr<SimulatedBuses> MakeSimulatedBuses(const config::StandConfig& stand, Clock& clock);

}  // namespace gyrobench::daemon
