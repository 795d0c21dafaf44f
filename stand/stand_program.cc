#include "stand/stand_program.h"

#include <fmt/format.h>
#include <pthread.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "config/scenario.h"
#include "config/stand_config.h"

namespace gyrobench::stand {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path config;
  std::optional<fs::path> scenario;
  std::optional<fs::path> faults;
  std::optional<fs::path> truth;
  std::optional<std::uint64_t> seed;
  std::optional<fs::path> link_dir;
  bool free_ports = false;
  bool list_keys = false;
};

// Symbolic links to the pseudo-terminals, gone with the program.
class Links {
 public:
  ~Links() {
    std::error_code ignored;  // nothing can be done about it on the way out
    for (const fs::path& link : links_) fs::remove(link, ignored);
  }
  void Make(const fs::path& dir, const config::BusConfig& bus) {
    fs::create_directories(dir);
    const fs::path link = dir / ("bus-" + bus.name);
    if (fs::is_symlink(link)) fs::remove(link);
    fs::create_symlink(bus.device, link);
    links_.push_back(link);
  }

 private:
  std::vector<fs::path> links_;
};

void ListKeys() {
  fmt::print("| key | unit | default | range | meaning |\n|---|---|---|---|---|\n");
  for (const auto& key : config::ScenarioKeys()) {
    fmt::print("| `{}` | {} | {} | {} | {} |\n", key.key, key.unit, key.default_value, key.range,
               key.help);
  }
}

config::Scenario ScenarioOf(const Options& options, const config::StandConfig& stand) {
  config::Scenario scenario;
  if (options.scenario) {
    scenario = config::LoadScenario(*options.scenario);
  } else if (stand.virtual_stand) {
    scenario = config::LoadScenario(stand.virtual_stand->scenario);
  }
  if (options.faults) scenario.faults = config::LoadFaults(*options.faults);
  return scenario;
}

void Run(const Options& options, const sigset_t& signals, const MakeGyroUnitOf& make_gyro_unit) {
  config::StandConfig config = config::LoadStandConfig(options.config);
  const config::Scenario scenario = ScenarioOf(options, config);
  const std::uint64_t configured_seed = config.virtual_stand ? config.virtual_stand->seed : 1;
  if (options.truth) {
    if (!config.virtual_stand) config.virtual_stand.emplace();
    config.virtual_stand->truth = *options.truth;
  }
  const auto clock = MakeSystemClock();
  VirtualStand::MakeGyroUnit make;
  if (make_gyro_unit) {
    make = [&](Physics& physics, Utime start) { return make_gyro_unit(config, physics, start); };
  }
  VirtualStand stand(config, scenario, options.seed.value_or(configured_seed), *clock, make);
  Links links;
  for (const config::BusConfig& bus : config.buses) {
    using Port = VirtualStand::Port;
    const auto served = stand.Serve(bus, options.free_ports ? Port::kFree : Port::kAsConfigured);
    if (served.transport == config::BusConfig::Transport::kTcp) {
      fmt::print("bus {}: {}:{}\n", served.name, served.host, served.port);
      continue;
    }
    if (options.link_dir) links.Make(*options.link_dir, served);
    fmt::print("bus {}: {}\n", served.name, served.device);
  }
  std::fflush(stdout);
  int signal = 0;
  sigwait(&signals, &signal);
}

int Main(int argc, const char* const* argv, const MakeGyroUnitOf& make_gyro_unit) {
  // Blocked before any thread starts, so that sigwait gets them.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  Options options;
  CLI::App app{
      "The virtual stand of gyrobench as a process of its own: serves the devices of a stand file\n"
      "in real time on Modbus TCP and pseudo-terminals, until SIGTERM or SIGINT."};
  app.footer(
      "Example:\n  gyrobench-stand --config config/virtual.toml --seed 7 --link ./run\n"
      "prints one line a bus, such as `bus a: /dev/pts/5`, and makes ./run/bus-a.");
  app.add_option("--config", options.config, "Stand file (TOML)");
  app.add_option(
      "--scenario", options.scenario,
      "Scenario file (TOML); without it the stand file's, without that a typical MPU-6050");
  app.add_option("--faults", options.faults,
                 "File of [[fault]] tables (TOML), in place of those of the scenario");
  app.add_option("--truth", options.truth,
                 "File to write: where the axes really were, and what they were told");
  app.add_option("--seed", options.seed, "Seed of specimen and noise; without it the stand file's");
  app.add_option("--link", options.link_dir,
                 "Folder in which to link each pseudo-terminal as bus-NAME");
  app.add_flag("--free-ports", options.free_ports, "Serve TCP buses on any free port of 127.0.0.1");
  app.add_flag("--list-keys", options.list_keys, "Print every key of a scenario file and end");
  CLI11_PARSE(app, argc, argv);
  if (options.list_keys) {
    ListKeys();
    return 0;
  }
  if (options.config.empty()) {
    fmt::print(stderr, "gyrobench-stand: --config FILE is missing; see --help\n");
    return 2;
  }
  Run(options, signals, make_gyro_unit);
  return 0;
}

}  // namespace

int RunStandProgram(int argc, const char* const* argv, const MakeGyroUnitOf& make_gyro_unit) {
  try {
    return Main(argc, argv, make_gyro_unit);
  } catch (const std::exception& error) {
    fmt::print(stderr, "gyrobench-stand: {}\n", error.what());
    return 1;
  }
}

}  // namespace gyrobench::stand
