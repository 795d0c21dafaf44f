// Blind trials: the virtual stand hides an effect in a recording, the tracer sees the recording
// alone, and this prints truth against verdict.
//
//   blind_trials --kind single --sets 20 --levels low,mid,high --jobs 2
//   blind_trials --kind single --effects bias.tone --levels high --only SEED --table FILE
//
// The second form writes the table of one set, by the seed that --json gives it, for a finding to
// be gone back to with gyrobench trace.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "recording/table_writer.h"
#include "tests/blind_trials/bound.h"
#include "tests/blind_trials/campaign.h"

namespace {

using namespace gyrobench::blind_trials;
namespace fs = std::filesystem;

struct Options {
  CampaignOptions campaign;
  std::vector<std::string> kinds = {"silent", "single", "pairs", "unknown", "poor"};
  std::vector<std::string> levels = {"low", "mid", "high"};
  std::string json, dump, table;
  std::optional<std::uint64_t> only;
  bool list = false, only_bounds = false;
};

void Describe(CLI::App& app, Options& options) {
  CampaignOptions& campaign = options.campaign;
  app.add_option("--kind", options.kinds, "silent, single, pairs, unknown, poor")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--sets", campaign.sets, "sets of each effect and level")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--silent-sets", campaign.silent_sets, "sets without an effect")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--levels", options.levels, "low, mid, high")
      ->delimiter(',')
      ->check(CLI::IsMember({"low", "mid", "high"}))
      ->capture_default_str();
  app.add_option("--effects", campaign.effects, "ids, all of the kind without it")->delimiter(',');
  app.add_option("--seed", campaign.seed, "of the whole campaign")->capture_default_str();
  app.add_option("--jobs", campaign.jobs, "threads")->check(CLI::Range(1, 256));
  app.add_option("--hypotheses", campaign.hypotheses,
                 "for the power that the bound permits: as many are tried at once")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--bounds", campaign.bounds, "sets of each effect for the bound; 0: without")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_flag("--only-bounds", options.only_bounds,
               "how many standard deviations each effect is, without tracing");
  app.add_option("--json", options.json, "file for all results");
  app.add_option("--dump", options.dump, "folder for truth and verdict, a line a set, by kind");
  auto* table =
      app.add_option("--table", options.table, "file for the table of one set, with --only");
  auto* only = app.add_option("--only", options.only,
                              "seed of one set, as --json gives it: it is not traced");
  only->needs(table);
  table->needs(only);
  app.add_flag("--list", options.list, "list what can be hidden, and its levels");
}

void List() {
  for (const auto* list : {&CatalogueInjections(), &UnknownInjections()}) {
    for (const Injection& injection : *list) {
      fmt::print("{:<24} {:>8} {:>8} {:>8}  {}\n", injection.id, injection.levels[0],
                 injection.levels[1], injection.levels[2], injection.unit);
    }
  }
}

void PrintBounds(const CampaignOptions& options) {
  for (const char* kind : {"single", "unknown"}) {
    CampaignOptions high = options;
    high.sets = options.bounds;
    high.levels = {kHigh};
    std::map<std::string, double> sum;
    std::vector<std::string> order;
    for (const TrialSpec& spec : PlanTrials(kind, high)) {
      const std::string& id = spec.effects.front().id;
      if (!sum.contains(id)) order.push_back(id);
      sum[id] += VisibilityAtBound(spec).sigmas / high.sets;
    }
    for (const std::string& id : order) {
      const Injection& injection = FindInjection(id);
      fmt::print("{:<24} sigma {:>9.2g} {:<14} levels in sigmas", id,
                 injection.levels[kHigh] / sum[id], injection.unit);
      for (const double level : injection.levels) {
        fmt::print(" {:>8.1f}", sum[id] * level / injection.levels[kHigh]);
      }
      fmt::print("\n");
    }
  }
}

void Write(const fs::path& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw gyrobench::DataError(fmt::format("{}: cannot be written", file.string()));
}

// The set of this seed, which is of the one kind, effect and level that the options have.
void WriteTable(const Options& options) {
  const std::vector<TrialSpec> specs = PlanTrials(options.kinds.front(), options.campaign);
  if (options.kinds.size() != 1 || specs.size() != 1)
    throw gyrobench::DataError(
        "--only wants one --kind, and of a single set its --effects and --levels");
  TrialSpec spec = specs.front();
  spec.seed = *options.only;
  gyrobench::recording::TableWriter writer(options.table);
  RecordTrial(spec, writer);
  writer.Close();
}

void Run(const std::string& kind, const Options& options, std::string& json) {
  const std::vector<TrialSpec> specs = PlanTrials(kind, options.campaign);
  const auto outcomes = RunTrials(specs, options.campaign.jobs, [&](std::size_t done) {
    fmt::print(stderr, "\r{}: {} of {} ", kind, done, specs.size());
  });
  fmt::print(stderr, "\n");
  fmt::print("{}, seed {}\n{}\n", kind, options.campaign.seed,
             Table(kind, outcomes, options.campaign));
  std::fflush(stdout);
  if (options.json.empty() && options.dump.empty()) return;
  const std::string lines = JsonLines(outcomes);
  if (!options.dump.empty()) Write(fs::path(options.dump) / (kind + ".jsonl"), lines);
  json += lines;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Blind trials: what the tracer says of recordings in which something is hidden");
  Options options;
  Describe(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.list) {
      List();
      return 0;
    }
    if (options.only_bounds) {
      PrintBounds(options.campaign);
      return 0;
    }
    options.campaign.levels.clear();
    for (const Level level : {kLow, kMid, kHigh}) {
      const auto& wanted = options.levels;
      if (std::find(wanted.begin(), wanted.end(), kLevelNames[level]) != wanted.end())
        options.campaign.levels.push_back(level);
    }
    if (options.only) {
      options.campaign.sets = options.campaign.silent_sets = 1;
      WriteTable(options);
      return 0;
    }
    if (!options.dump.empty()) fs::create_directories(options.dump);
    std::string json;
    for (const std::string& kind : options.kinds) Run(kind, options, json);
    if (!options.json.empty()) Write(options.json, json);
  } catch (const std::exception& error) {
    fmt::print(stderr, "blind_trials: {}\n", error.what());
    return 1;
  }
  return 0;
}
