#include "tests/blind_trials/loop.h"

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <mutex>
#include <random>
#include <set>
#include <thread>

#include "procedures/engine/engine.h"
#include "stand/random.h"
#include "tests/blind_trials/trial.h"
#include "tests/blind_trials/trial_bench.h"

namespace gyrobench::blind_trials {
namespace {

struct Task {
  std::uint64_t seed = 0;
  std::vector<HiddenEffect> effects;
};

// Steps happen by themselves: no manoeuvre brings them about.
const std::set<std::string> kNotExcited = {"bias.step", "angle.step"};
// Their middle level is below 10 standard deviations.
const std::set<std::string> kFaint = {"bias.warm_up", "angle.eccentricity_2"};

std::vector<Task> Plan(const LoopCampaign& campaign) {
  std::vector<std::string> ids = campaign.effects;
  if (ids.empty()) {
    for (const Injection& injection : CatalogueInjections()) {
      if (!kNotExcited.contains(injection.id)) ids.push_back(injection.id);
    }
  }
  for (const std::string& id : ids) FindInjection(id);
  std::mt19937_64 random(stand::Mix(campaign.seed));
  std::vector<Task> tasks;
  for (int i = 0; i < campaign.trials; ++i) {
    const std::string& id = ids[random() % ids.size()];
    const Level level = kFaint.contains(id) || random() % 2 == 0 ? kHigh : kMid;
    tasks.push_back({random(), {{id, level}}});
  }
  for (int i = 0; i < campaign.silent; ++i) tasks.push_back({random(), {}});
  return tasks;
}

void Fill(TrialBench& bench, LoopOutcome* outcome) {
  outcome->duration_s = bench.ElapsedS();
  outcome->said = bench.said();
  outcome->manoeuvres = static_cast<int>(
      std::count_if(outcome->said.begin(), outcome->said.end(),
                    [](const std::string& text) { return text.starts_with("manoeuvre "); }));
  for (const calibration::ChannelTrace& channel : bench.Traced().result.channels) {
    for (const calibration::TracedEffect& effect : channel.effects)
      outcome->named.push_back({effect.id, effect.rivals});
  }
}

LoopOutcome RunOne(const Task& task, double budget_min) {
  LoopOutcome outcome;
  outcome.seed = task.seed;
  if (!task.effects.empty()) outcome.hidden = task.effects.front().id;
  std::mt19937_64 random(stand::Mix(task.seed));
  TrialSpec spec;
  spec.seed = task.seed;
  spec.effects = task.effects;
  const PartSeeds seeds = DrawSeeds(spec, random);
  const DrawnTrial drawn = DrawTrial(spec, seeds, 60.0 * budget_min, random);
  try {
    TrialBench bench(TrialStand(), drawn.bench.specimen, seeds.noise, drawn.bench.options);
    const auto procedure = procedures::Procedure::Load(std::filesystem::path(GYROBENCH_SOURCE_DIR) /
                                                       "procedures/close_loop.lua");
    procedures::RunProcedure(procedure, {{"budget_min", budget_min}}, bench);
    Fill(bench, &outcome);
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  return outcome;
}

}  // namespace

bool LoopOutcome::Right() const {
  if (!failure.empty()) return false;
  if (hidden.empty()) return named.empty();
  return named.size() == 1 && named[0].id == hidden && named[0].rivals.empty();
}

bool LoopOutcome::Among() const {
  return std::any_of(named.begin(), named.end(), [&](const Name& name) {
    return name.id == hidden || std::ranges::find(name.rivals, hidden) != name.rivals.end();
  });
}

bool LoopOutcome::Wrong() const {
  return std::any_of(named.begin(), named.end(),
                     [&](const Name& name) { return name.id != hidden && name.rivals.empty(); });
}

std::vector<LoopOutcome> RunLoops(const LoopCampaign& campaign,
                                  const std::function<void(const LoopOutcome&)>& done) {
  const std::vector<Task> tasks = Plan(campaign);
  std::vector<LoopOutcome> outcomes(tasks.size());
  std::atomic<std::size_t> next = 0;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < tasks.size(); i = next++) {
      outcomes[i] = RunOne(tasks[i], campaign.budget_min);
      const std::lock_guard lock(mutex);
      done(outcomes[i]);
    }
  };
  std::vector<std::jthread> threads;
  for (int i = 1; i < campaign.jobs; ++i) threads.emplace_back(work);
  work();
  threads.clear();
  return outcomes;
}

}  // namespace gyrobench::blind_trials
