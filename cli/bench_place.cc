#include "cli/bench_place.h"

#include <fmt/format.h>

#include <cstdlib>
#include <utility>

#include "cli/exit_status.h"
#include "config/stand_config.h"

namespace gyrobench::cli {
namespace {

constexpr const char* kInstalledStandFile = "/etc/gyrobench/stand.toml";

std::filesystem::path FindStandFile(const std::filesystem::path& option) {
  if (!option.empty()) return option;
  if (const char* file = std::getenv("GYROBENCH_CONFIG"); file != nullptr && *file != '\0') {
    return file;
  }
  std::error_code none;
  if (std::filesystem::exists(kInstalledStandFile, none)) return kInstalledStandFile;
  return {};
}

}  // namespace

BenchPlace::BenchPlace(BenchOptions options)
    : options_(std::move(options)), stand_file_(FindStandFile(options_.config)) {}

std::filesystem::path BenchPlace::Socket() const {
  if (!options_.socket.empty()) return options_.socket;
  if (stand_file_.empty()) {
    throw UsageError(
        "which bench? name its stand file with --config FILE or $GYROBENCH_CONFIG, or the daemon's "
        "control socket with --socket PATH");
  }
  return config::LoadStandConfig(stand_file_).control_socket;
}

config::StandConfig BenchPlace::Stand() const {
  if (stand_file_.empty()) {
    throw UsageError("which bench? name its stand file with --config FILE or $GYROBENCH_CONFIG");
  }
  return config::LoadStandConfig(stand_file_);
}

std::filesystem::path BenchPlace::Records() const {
  if (!options_.records.empty()) return options_.records;
  if (stand_file_.empty()) {
    throw UsageError(
        "which records? name the folder with --records DIR, or the stand file with --config FILE "
        "or "
        "$GYROBENCH_CONFIG");
  }
  return config::LoadStandConfig(stand_file_).records;
}

std::string BenchPlace::LcmUrl() const {
  if (!options_.lcm_url.empty()) return options_.lcm_url;
  if (stand_file_.empty()) return config::LcmConfig{}.url;
  return config::LoadStandConfig(stand_file_).lcm.url;
}

std::string BenchPlace::ChannelPrefix() const {
  if (!options_.channel_prefix.empty()) return options_.channel_prefix;
  if (stand_file_.empty()) return config::LcmConfig{}.channel_prefix;
  return config::LoadStandConfig(stand_file_).lcm.channel_prefix;
}

bool BenchPlace::KnowsItsDaemon() const {
  if (!options_.socket.empty()) return true;
  const bool elsewhere = !options_.lcm_url.empty() || !options_.channel_prefix.empty();
  return !stand_file_.empty() && !elsewhere;
}

std::string BenchPlace::DaemonCommand() const {
  return fmt::format("gyrobenchd --config {}",
                     stand_file_.empty() ? std::string("FILE") : stand_file_.string());
}

}  // namespace gyrobench::cli
