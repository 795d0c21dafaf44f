// Reads the emulated unit for a time and counts what came of it.
#pragma once

#include <cstdint>
#include <filesystem>

namespace gyrobench::firmware {

struct Reading {
  int divider = 4;  // sample rate = 1000 / (1 + divider) Hz
  int filter = 3;
  int baud = 115200;
  double duration_s = 5.0;
  double poll_s = 0.02;
  double damaged = 0.0;  // share of the requests with which something happens
  int resets = 0;        // at moments that are drawn
  int stuck = 0;         // times that the sensor holds its bus
  double sensor_clock_rel = 0.0, resonator_rel = 0.0;
  std::uint64_t seed = 1;
};

struct ReadingCounts {
  std::int64_t taken = 0;    // samples that were read
  std::int64_t missing = 0;  // that the sensor made between two that were read, one after the other
  std::int64_t repeated = 0;   // read twice, or in a wrong order
  std::int64_t wrong = 0;      // of which a value is not what the sensor showed
  std::int64_t late = 0;       // whose tick is not that of its data-ready pulse, within 5 ticks
  std::int64_t told_lost = 0;  // by the unit's own counter
  std::int64_t sensor_errors = 0, frames_rejected = 0;
  std::int64_t requests = 0, unanswered = 0;
  int restarts_seen = 0;  // by the boot counter
  std::size_t stack_left = 0;
  // Of the line of ticks over time, against the processor's own rate [1].
  double tick_rate_rel = 0.0;
};

// The sensor's samples carry their number, so that each can be told. After a damaged frame the
// same block is asked for again. Samples around a reset or a bus that is held are not missing.
ReadingCounts ReadFor(const std::filesystem::path& image, const Reading& reading);

}  // namespace gyrobench::firmware
