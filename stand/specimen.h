// From a scenario with spreads to one specimen.
#pragma once

#include <cstdint>

#include "config/scenario.h"

namespace gyrobench::stand {

// Draws what differs from part to part (Scenario::drawn) and adds it to the values of the scenario.
// The result has no spread left. The same seed gives the same specimen; a spread of zero leaves the
// others' draws as they are.
config::Scenario DrawSpecimen(const config::Scenario& scenario, std::uint64_t seed);

}  // namespace gyrobench::stand
