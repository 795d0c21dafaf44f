// The firmware's image in an emulated processor for as long as it is told, as a table: what was
// lost, doubled or wrong. Exit status 1 where anything was.
//   bench_firmware --minutes 30
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <vector>

#include "tests/firmware/emulation/reading.h"

namespace {

struct Case {
  const char* name;
  gyrobench::firmware::Reading reading;
};

int Run(int argc, char** argv) {
  double minutes = 1.0;
  CLI::App app{"Reads the emulated gyro unit and counts what came of it."};
  app.add_option("--minutes", minutes, "emulated time at 200 Hz; a sixth of it at 1 kHz");
  CLI11_PARSE(app, argc, argv);
  const double long_s = 60.0 * minutes, short_s = 10.0 * minutes;
  const std::vector<Case> cases = {
      {"200 Hz, 115200 baud", {.baud = 115200, .duration_s = long_s}},
      {"200 Hz, 500000 baud", {.baud = 500000, .duration_s = long_s}},
      {"1 kHz, 500000 baud", {.divider = 0, .baud = 500000, .duration_s = short_s, .poll_s = 0.01}},
      {"1 % of frames damaged", {.duration_s = short_s, .damaged = 0.01}},
      {"10 resets", {.duration_s = 40.0, .resets = 10}},
      {"bus held 10 times", {.duration_s = 20.0, .stuck = 10}},
  };
  fmt::print("{:24} {:>9} {:>8} {:>8} {:>6} {:>6} {:>10} {:>9} {:>9} {:>9} {:>10}\n", "", "samples",
             "missing", "doubled", "wrong", "late", "told lost", "requests", "no reply", "restarts",
             "stack left");
  bool all_well = true;
  for (const Case& one : cases) {
    const auto counts = gyrobench::firmware::ReadFor(GYROBENCH_FIRMWARE_IMAGE, one.reading);
    fmt::print("{:24} {:>9} {:>8} {:>8} {:>6} {:>6} {:>10} {:>9} {:>9} {:>9} {:>10}\n", one.name,
               counts.taken, counts.missing, counts.repeated, counts.wrong, counts.late,
               counts.told_lost, counts.requests, counts.unanswered, counts.restarts_seen,
               counts.stack_left);
    all_well = all_well && counts.missing + counts.repeated + counts.wrong + counts.late == 0 &&
               counts.restarts_seen == one.reading.resets;
  }
  return all_well ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return Run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_firmware: %s\n", error.what());
    return 1;
  }
}
