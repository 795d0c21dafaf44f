#include "base/error.h"
#include "daemon/simulated_buses.h"

namespace gyrobench::daemon {

std::unique_ptr<SimulatedBuses> MakeSimulatedBuses(const config::StandConfig& stand,
                                                   Clock& /*clock*/) {
  throw ConfigError(stand.file.string() +
                    ": [virtual]: this gyrobenchd was built without the virtual stand "
                    "(GYROBENCH_VIRTUAL_STAND=OFF). Remove the table to use the hardware");
}

}  // namespace gyrobench::daemon
