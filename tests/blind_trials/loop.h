// close_loop on the physics of the virtual stand, with something hidden in it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace gyrobench::blind_trials {

struct LoopCampaign {
  int trials = 100;
  int silent = 50;
  std::vector<std::string> effects;  // ids; empty: all that a manoeuvre excites
  std::uint64_t seed = 1;
  double budget_min = 30.0;
  int jobs = 1;
};

struct LoopOutcome {
  struct Name {
    std::string id;
    std::vector<std::string> rivals;
  };
  std::uint64_t seed = 0;
  std::string hidden;  // id; empty: nothing
  std::vector<Name> named;
  double duration_s = 0.0;  // of bench time
  int manoeuvres = 0;
  std::vector<std::string> said;
  std::string failure;

  // What is hidden is the only name, without rivals; silence where nothing is hidden.
  bool Right() const;
  // What is hidden is named or a rival of a name.
  bool Among() const;
  // A name without rivals that is not what is hidden.
  bool Wrong() const;
};

// Effects are drawn at random at 10 standard deviations of the full sequence and more. `done` is
// called after each, one at a time. Throws DataError for an unknown id.
std::vector<LoopOutcome> RunLoops(const LoopCampaign& campaign,
                                  const std::function<void(const LoopOutcome&)>& done);

}  // namespace gyrobench::blind_trials
