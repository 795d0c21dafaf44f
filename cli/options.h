// The command line, read.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cli/bench_place.h"

namespace gyrobench::cli {

struct Options {
  std::string command;  // "run", "status" ...
  BenchOptions bench;
  bool json = false;
  std::string name;                                             // procedure or run
  std::vector<std::pair<std::string, std::string>> parameters;  // -p key=value
  bool detach = false;
  std::string answer;
  std::int64_t count = 0;  // watch: messages to print, 0 = no end
  bool until_stop = false;
  double every_s = 0.0;  // bus: again and again, 0 = once
  bool data = false;     // watch: samples too
  std::vector<std::string> inputs;
  std::filesystem::path output;
  bool overwrite = false;
  bool quiet = false;
  std::filesystem::path calibration;  // trace: to write; apply: to read
  std::filesystem::path report;       // trace: to write
  std::uint64_t seed = 1;             // trace
  bool any_sensor = false;            // apply
  bool g_sensitivity = false;         // hold
  bool markdown = false;              // effects
  std::vector<std::string> buses;     // devices; empty: all
  std::vector<int> units;             // devices: unit numbers to ask
  std::vector<int> baud_rates;        // devices: to ask at, in place of the stand file's
  bool write = false, yes = false;    // devices: into drives; without a question
  std::string format;                 // export, of a calibration
};

// The options, or the exit status when there is nothing more to do (help was printed, or an error
// of usage).
std::variant<Options, int> ParseOptions(int argc, const char* const* argv);

}  // namespace gyrobench::cli
