// gyrobenchd: the daemon.
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <exception>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "base/version.h"
#include "config/stand_config.h"
#include "daemon/daemon.h"

namespace {

// Blocked before any thread starts, so that only the main thread's sigwait sees them.
sigset_t BlockStopSignals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file at its limit is an error of the write, not the end of the daemon
  return signals;
}

// The client reads stand files too, and needs no procedures: the daemon does.
void CheckProcedureFolders(const std::string& config_file,
                           const gyrobench::config::StandConfig& stand) {
  for (const std::filesystem::path& folder : stand.procedure_dirs) {
    if (std::filesystem::is_directory(folder)) continue;
    throw gyrobench::ConfigError(
        fmt::format("{}: procedures: {}: no such folder; paths are relative to the stand file",
                    config_file, folder.string()));
  }
}

int Serve(const std::string& config_file, bool check_only) {
  const gyrobench::config::StandConfig stand = gyrobench::config::LoadStandConfig(config_file);
  CheckProcedureFolders(config_file, stand);
  if (check_only) {
    fmt::print("{}: stand '{}' with {} axes: no fault found\n", config_file, stand.name,
               stand.axes.size());
    return 0;
  }
  const sigset_t signals = BlockStopSignals();
  {
    const gyrobench::daemon::Daemon daemon(stand);
    spdlog::info("ready: {} (control socket {})", stand.name, stand.control_socket.string());
    sd_notify(0, "READY=1");
    int signal = 0;
    sigwait(&signals, &signal);
    spdlog::info("stopping on signal {}", signal);
    sd_notify(0, "STOPPING=1");
  }
  spdlog::info("stopped");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("gyrobenchd"));
  CLI::App app{
      "gyrobenchd drives the stand, samples gyro and reference, runs procedures by name and "
      "publishes "
      "results over LCM. It stays in the foreground; SIGTERM ends it in order.\n"
      "Example: gyrobenchd --config config/virtual.toml"};
  std::string config_file;
  bool check_only = false;
  app.add_option("--config", config_file, "stand file (docs/configuration.md)")
      ->required()
      ->envname("GYROBENCH_CONFIG");
  app.add_flag("--check", check_only, "read the stand file, say what is wrong with it, and end");
  app.set_version_flag("--version", gyrobench::kVersion);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return Serve(config_file, check_only);
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
    return 1;
  }
}
