// Where the bench is: control socket, records and LCM, from the stand file or from options.
#pragma once

#include <filesystem>
#include <string>

#include "config/stand_config.h"

namespace gyrobench::cli {

// As given on the command line; empty where not given.
struct BenchOptions {
  std::filesystem::path config;
  std::filesystem::path socket;
  std::filesystem::path records;
  std::string lcm_url;
  std::string channel_prefix;
};

// An option wins over the stand file, --config over $GYROBENCH_CONFIG, and that over
// /etc/gyrobench/stand.toml where there is one. The stand file is read when first asked for, so
// that a command that needs none works without.
class BenchPlace {
 public:
  explicit BenchPlace(BenchOptions options);
  // UsageError when neither option nor stand file says it; ConfigError when the file cannot be
  // used.
  std::filesystem::path Socket() const;
  config::StandConfig Stand() const;
  std::filesystem::path Records() const;
  // With neither option nor stand file: the defaults of config::LcmConfig.
  std::string LcmUrl() const;
  std::string ChannelPrefix() const;
  // Whether control socket and LCM are said to be of one daemon: both by the stand file, or both by
  // options.
  bool KnowsItsDaemon() const;
  // What to type to start the daemon that was looked for.
  std::string DaemonCommand() const;

 private:
  BenchOptions options_;
  std::filesystem::path stand_file_;  // empty: none
};

}  // namespace gyrobench::cli
