// How often, how fast and how well the units of one line answer.
#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"

namespace gyrobench::drivers {

// Times, counted in classes of a quarter octave: a quantile is right within a tenth.
class Latencies {
 public:
  void Add(Utime latency_us);
  Latencies& operator+=(const Latencies& more);
  std::int64_t count() const;
  // The time within which this share (0 to 1) of them was; NaN where there is none.
  double Quantile_s(double share) const;

 private:
  static constexpr int kPerOctave = 4, kOctaves = 26;  // up to a minute
  std::array<std::uint32_t, kPerOctave* kOctaves> counts_ = {};
};

// Of one unit in a span of time. Tries that failed are counted by what came.
struct UnitFigures {
  std::string device;
  int unit = 0;
  std::int64_t transactions = 0;  // asked for, whatever their end
  std::int64_t retries = 0;       // tries beyond the first
  std::int64_t given_up = 0;      // transactions without an answer that can be used
  std::int64_t silent = 0;        // no whole reply in time, or a gateway's word that there was none
  std::int64_t unreadable = 0;    // a reply that is no sound frame, or not of this request
  std::int64_t refused = 0;       // a Modbus exception
  std::int64_t line_lost = 0;     // the line could not be opened, or was gone
  Utime busy_us = 0;    // for so long the line did nothing else: waiting after a failure is in it
  Latencies latencies;  // from request to reply

  UnitFigures& operator+=(const UnitFigures& more);
};

struct LineFigures {
  std::string bus;          // its name in the stand file
  std::string description;  // "bus a (/dev/ttyUSB0, 115200 baud 8N1)"
  // Between begin and now; recent: the last ten to thirty seconds of them.
  Utime utime_begin = 0, utime_recent = 0, utime_now = 0;
  std::vector<UnitFigures> all, recent;  // in the order in which they were first asked
};

// Counts what happens on a line. Written by the line's thread, asked from any. Allocates when a
// unit is asked for the first time, and not after that.
class LineRecorder {
 public:
  struct Transaction {
    int tries = 1, silent = 0, unreadable = 0, refused = 0, line_lost = 0;
    bool given_up = false;
    Utime latency_us = 0;  // of the try that succeeded
    Utime busy_us = 0;
  };

  explicit LineRecorder(Utime begin);
  void Add(std::string_view device, int unit, Utime now, const Transaction& transaction);
  // Without the line's names.
  LineFigures Figures(Utime now) const;

 private:
  static constexpr Utime kSpan = 10 * kMicrosecondsPerSecond;
  // Of all units, in one span of time.
  struct Span {
    Utime begin = 0;
    std::vector<UnitFigures> units;
  };
  static void Empty(Span& span, Utime begin);
  void BeginSpan(Utime now);

  mutable std::mutex mutex_;
  Utime begin_;
  std::vector<UnitFigures> all_;
  Span before_, current_;
};

}  // namespace gyrobench::drivers
