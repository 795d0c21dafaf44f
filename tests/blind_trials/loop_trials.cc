// The closed loop on trials: an effect is hidden, close_loop asks for manoeuvres until the verdict
// is settled, and this prints truth against verdict, and the bench time that it took.
//
//   loop_trials --trials 100 --silent 50 --jobs 2
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>

#include "tests/blind_trials/loop.h"

namespace {

using namespace gyrobench::blind_trials;

constexpr double kFullSequence_s = 2262.0;

void Print(const LoopOutcome& outcome, bool talks) {
  std::vector<std::string> named;
  for (const LoopOutcome::Name& name : outcome.named) {
    named.push_back(name.rivals.empty()
                        ? name.id
                        : fmt::format("{} (or {})", name.id, fmt::join(name.rivals, " or ")));
  }
  fmt::print("{:<22} {:>5.1f} min {:>3} manoeuvres  {}{}\n",
             outcome.hidden.empty() ? "nothing" : outcome.hidden, outcome.duration_s / 60.0,
             outcome.manoeuvres,
             named.empty() ? "silent" : fmt::format("{}", fmt::join(named, "; ")),
             outcome.Right() ? "" : fmt::format("   <- seed {}", outcome.seed));
  if (!outcome.failure.empty()) fmt::print("  {}\n", outcome.failure);
  if (talks) {
    for (const std::string& text : outcome.said) fmt::print("    {}\n", text);
  }
  std::fflush(stdout);
}

void Summarise(const char* what, const std::vector<LoopOutcome>& outcomes) {
  if (outcomes.empty()) return;
  std::vector<double> durations;
  double right = 0, among = 0, wrong = 0;
  for (const LoopOutcome& outcome : outcomes) {
    durations.push_back(outcome.duration_s);
    right += outcome.Right();
    among += outcome.Among();
    wrong += outcome.Wrong();
  }
  const auto n = static_cast<double>(outcomes.size());
  const auto middle = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::nth_element(durations.begin(), middle, durations.end());
  fmt::print(
      "{}: {} trials; right alone {:.1f} %, right among others {:.1f} %, wrong {:.1f} %; "
      "median {:.1f} min of bench time, {:.0f} % of the full sequence\n",
      what, outcomes.size(), 100 * right / n, 100 * among / n, 100 * wrong / n, *middle / 60.0,
      100 * *middle / kFullSequence_s);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Closed-loop trials: does the stand find what is hidden by choosing its manoeuvres?");
  LoopCampaign campaign;
  bool talks = false;
  app.add_option("--trials", campaign.trials, "with an effect")->capture_default_str();
  app.add_option("--silent", campaign.silent, "without an effect")->capture_default_str();
  app.add_option("--effects", campaign.effects, "ids to draw from, all without it")->delimiter(',');
  app.add_option("--seed", campaign.seed, "of the whole campaign")->capture_default_str();
  app.add_option("--budget", campaign.budget_min, "of bench time, minutes")->capture_default_str();
  app.add_option("--jobs", campaign.jobs, "threads")->check(CLI::Range(1, 256));
  app.add_flag("--talk", talks, "what the procedure says");
  CLI11_PARSE(app, argc, argv);
  try {
    const auto outcomes =
        RunLoops(campaign, [&](const LoopOutcome& outcome) { Print(outcome, talks); });
    std::vector<LoopOutcome> hidden, silent;
    for (const LoopOutcome& outcome : outcomes)
      (outcome.hidden.empty() ? silent : hidden).push_back(outcome);
    Summarise("an effect hidden", hidden);
    Summarise("nothing hidden", silent);
  } catch (const std::exception& error) {
    fmt::print(stderr, "loop_trials: {}\n", error.what());
    return 1;
  }
  return 0;
}
