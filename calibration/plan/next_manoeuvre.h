// Which manoeuvre of a menu tells the most, per minute, of what the measurements so far leave open.
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "calibration/plan/foresee.h"
#include "calibration/trace/trace.h"

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

// What is expected of one manoeuvre [nats: natural logarithms of odds].
struct ManoeuvreWorth {
  double nats = 0.0;
  double nats_per_min = 0.0;
  std::string because;  // "tells angle.latency from bandwidth.first_order"
};

struct NextManoeuvre {
  // Effects are named, and every other of the catalogue, put in the place of one of them, would
  // leave odds of e^8 and more against itself; of e^5 where the trace tells the two apart.
  bool settled = false;
  std::string open;  // what is not settled, in words; empty when all is
  // Pairs that are not to be separated on this stand: the best of the menu, made for as long as
  // there is time, would not tell them apart, or what was made for it did not. They do not count.
  std::string never;
  std::string newly_closed;  // those of them that were open until now
  // Effects that are small beside others that are not, as axis and id ("x", "angle.ripple"), and
  // the pairs of them that are open, in words: they hold no verdict up and are not asked for.
  std::set<std::pair<std::string, std::string>> small;
  std::string small_pairs;
  // Of the menu, also when all is settled; none where nothing more would be known by any of it.
  std::optional<std::size_t> best;
  std::vector<ManoeuvreWorth> worths;  // in the menu's order
};

// Expected discrimination: where an effect is named, by how much the log-likelihood ratio between
// it and each other effect of the catalogue would grow if it is the cause, as long as that is open.
// Beside it, as far as each may be there at all: by how much more would be known of each effect of
// the catalogue, from the largest size of such parts down to a hundredth of it; in full where
// nothing is to be told apart. Both under the noise that the trace found,
// the baseline free; non-linear effects at the points of their grids. `traced`: of `so_far` alone.
// `memory`: of the run's choices before, brought up to date with this one. `small_below`: effects
// of one id are small where ShareOfError of each of them is less; where all effects are, none is.
// Throws DataError where
// the reference is not that of a stand.
NextManoeuvre ChooseManoeuvre(const Recording& so_far, const Traced& traced,
                              std::span<const Manoeuvre> menu, LoopMemory& memory,
                              double small_below = 0.0);
// The same as a run's first choice, without an end of bench time.
NextManoeuvre ChooseManoeuvre(const Recording& so_far, const Traced& traced,
                              std::span<const Manoeuvre> menu);

}  // namespace gyrobench::calibration
