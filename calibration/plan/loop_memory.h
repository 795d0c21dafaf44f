// What a loop of choices knows beside its measurements.
#pragma once

#include <limits>
#include <map>
#include <set>
#include <string>

namespace gyrobench::calibration {

// One for each run. A pair is "z: angle.latency or bandwidth.first_order": two effects that explain
// the same so far.
struct LoopMemory {
  // Bench time that is left for manoeuvres.
  double left_min = std::numeric_limits<double>::infinity();
  // Pairs that are not to be separated on this stand: they are not asked for again.
  std::set<std::string> closed;
  // What was expected, in sum, of the manoeuvres that were chosen while the pair was open [nats].
  std::map<std::string, double> asked_nats;
};

}  // namespace gyrobench::calibration
