// The vector calibration against the truth: the virtual stand runs the full sequence with a part
// whose matrix, bias and g-sensitivity are drawn, the tracer sees the recording alone, and this
// prints errors over the Cramer-Rao bound, coverage, and what is left on a sequence never fitted.
//
//   vector_trials --sets 50 --seed 1
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>

#include "tests/blind_trials/vector_trial.h"

int main(int argc, char** argv) {
  using namespace gyrobench::blind_trials;
  CLI::App app("Vector calibration on the virtual stand against the truth");
  std::uint64_t seed = 1;
  int sets = 10;
  app.add_option("--seed", seed, "of the first set")->capture_default_str();
  app.add_option("--sets", sets, "seeds")->check(CLI::PositiveNumber)->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  try {
    std::vector<VectorOutcome> outcomes;
    for (int i = 0; i < sets; ++i) {
      outcomes.push_back(RunVectorTrial(seed + static_cast<std::uint64_t>(i)));
      const VectorOutcome& last = outcomes.back();
      fmt::print("{} {}: {}; elsewhere {:.4f} {:.4f} {:.4f} {}\n", last.seed,
                 kNoiseNames[static_cast<std::size_t>(last.noise)], last.effects,
                 last.elsewhere_whitened_rms[0], last.elsewhere_whitened_rms[1],
                 last.elsewhere_whitened_rms[2], last.failure);
      std::fflush(stdout);
    }
    fmt::print("{}", VectorTable(outcomes));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "vector_trials: {}\n", error.what());
    return 1;
  }
}
