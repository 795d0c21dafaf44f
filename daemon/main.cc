// gyrobenchd: the daemon.
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>

#include "base/error.h"
#include "base/version.h"
#include "config/stand_config.h"
#include "daemon/daemon.h"
#include "daemon/daemon_log.h"
#include "recording/run_directory.h"

namespace {

// A terminal that closes (SIGHUP) or is typed into (SIGINT, SIGQUIT) ends the daemon as its manager
// does (SIGTERM): the run is aborted, the axes stop, the heater is off, the record is closed.
constexpr int kEnding[] = {SIGTERM, SIGINT, SIGHUP, SIGQUIT, SIGXCPU};
// Any of these would end or freeze the daemon, and leave whatever moves or heats to itself.
// SIGXFSZ: a file at its limit is an error of the write.
constexpr int kIgnored[] = {SIGPIPE, SIGXFSZ, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM,
                            SIGPROF, SIGIO,   SIGPWR,  SIGTSTP, SIGTTIN, SIGTTOU};

// Blocked before any thread starts that may take them, so that only the main thread's sigwait sees
// them. Who starts the daemon with SIGHUP ignored (nohup) wants it to outlive the terminal.
sigset_t PrepareSignals() {
  sigset_t ending;
  sigemptyset(&ending);
  for (const int signal : kEnding) {
    struct sigaction now {};
    sigaction(signal, nullptr, &now);
    if (now.sa_handler != SIG_IGN) sigaddset(&ending, signal);
  }
  pthread_sigmask(SIG_BLOCK, &ending, nullptr);
  for (const int signal : kIgnored) std::signal(signal, SIG_IGN);
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) std::signal(signal, SIG_IGN);
  return ending;
}

// Tells the service manager, where it asked for that (WatchdogSec=), that buses and main thread are
// alive. Where one hangs it is told nothing, and starts the daemon anew, which stops what moves.
int AwaitEnd(const sigset_t& ending, const gyrobench::daemon::Daemon& daemon) {
  std::uint64_t watchdog_us = 0;
  const bool watched = sd_watchdog_enabled(0, &watchdog_us) > 0;
  const std::uint64_t period_us = watched ? watchdog_us / 3 : 3'600'000'000;
  const timespec period = {static_cast<time_t>(period_us / 1'000'000),
                           static_cast<long>(period_us % 1'000'000 * 1000)};
  for (bool told = false;;) {
    const std::string stuck = daemon.Stuck();
    if (stuck.empty() && watched) sd_notify(0, "WATCHDOG=1");
    if (!stuck.empty() && !told) spdlog::critical("{}", stuck);
    told = !stuck.empty();
    const int signal = sigtimedwait(&ending, nullptr, &period);
    if (signal > 0) return signal;
  }
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

// A stand whose disk fails is served all the same: what moves has to be stopped, and status to be
// told.
void WarnOfRecords(const gyrobench::config::StandConfig& stand) {
  try {
    gyrobench::recording::RequireWritable(stand.records);
  } catch (const gyrobench::Error& error) {
    spdlog::error("{}. No run begins until then", error.what());
  }
}

int Serve(const std::string& config_file, bool check_only) {
  const gyrobench::config::StandConfig stand = gyrobench::config::LoadStandConfig(config_file);
  CheckProcedureFolders(config_file, stand);
  if (check_only) {
    gyrobench::recording::RequireWritable(stand.records);
    fmt::print("{}: stand '{}' with {} axes: no fault found\n", config_file, stand.name,
               stand.axes.size());
    return 0;
  }
  WarnOfRecords(stand);
  const sigset_t signals = PrepareSignals();
  {
    const gyrobench::daemon::Daemon daemon(stand);
    spdlog::info("ready: {} (control socket {})", stand.name, stand.control_socket.string());
    sd_notify(0, "READY=1");
    const int signal = AwaitEnd(signals, daemon);
    spdlog::info("stopping on signal {} ({})", signal, sigdescr_np(signal));
    sd_notify(0, "STOPPING=1");
  }
  spdlog::info("stopped");
  return 0;
}

int Main(int argc, char** argv) {
  CLI::App app{
      "gyrobenchd drives the stand, samples gyro and reference, runs procedures by name and "
      "publishes "
      "results over LCM. It stays in the foreground; SIGTERM, SIGINT, and SIGHUP from a terminal "
      "that closes end it in order.\n"
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
  return Serve(config_file, check_only);
}

// All threads draw on one store of memory: with one each, what a run's analysis has freed is of no
// use to the next one's, and the daemon grows for hours before it stays as it is.
void ShareFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 1);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  ShareFreedMemory();
  gyrobench::daemon::DaemonLog log;
  int status = 1;
  try {
    status = Main(argc, argv);
  } catch (const std::exception& error) {
    spdlog::error("{}", error.what());
  }
  if (log.Close()) return status;
  std::fflush(stdout);
  std::_Exit(status);
}
