// What can be hidden in a recording: effects of the catalogue at three levels, and what is in no
// catalogue. Written from the catalogue's design and the stand's keys, apart from the tracer.
#pragma once

#include <array>
#include <random>
#include <string>
#include <vector>

#include "config/scenario.h"
#include "tests/blind_trials/bench_recorder.h"

namespace gyrobench::blind_trials {

// What a trial draws.
using Random = std::mt19937_64;
inline double Uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

// A true number behind an effect, under the catalogue's name for it, in its unit. Several names:
// the length of that vector (amplitude of a sine and a cosine), whose phase is of no interest.
struct TrueParameter {
  std::vector<std::string> names;
  double value = 0.0;
  bool signless = false;  // the sign is a matter of convention
};

// A recording in the making.
struct Bench {
  config::Scenario specimen;
  RecorderOptions options;
  std::vector<TrueParameter> truth;  // of the effect injected last
  double duration_s = 0.0;
};

struct Injection {
  std::string id;  // the catalogue's, or one of our own for what is in no catalogue
  std::string unit;
  std::array<double, 3> levels = {};  // low, mid, high
  // Ids that name it rightly. For an effect of the catalogue its own.
  std::vector<std::string> right_ids;
  bool in_catalogue = true;
  // Adds it to the bench: sign, direction and phase at random.
  void (*apply)(Bench& bench, double level, std::mt19937_64& random) = nullptr;
};

// The 17 rows of the table of bounds, then bias.step, bias.tone, angle.ripple and angle.step.
const std::vector<Injection>& CatalogueInjections();
// In no catalogue. Levels are about 10, 30 and 100 standard deviations.
const std::vector<Injection>& UnknownInjections();
// Of either list. Throws DataError for an id that neither has.
const Injection& FindInjection(const std::string& id);

}  // namespace gyrobench::blind_trials
