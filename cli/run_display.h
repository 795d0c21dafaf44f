// How a run that is followed looks: a bar redrawn in place, or plain lines.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "presentation/text_layout.h"

namespace gyrobench::cli {

struct RunView {
  std::string state;    // of the daemon: running, paused, asking, stopping
  std::string segment;  // "turn 12 of 40"
  std::int64_t segments_done = 0;
  double progress = 0.0;     // 0..1
  double elapsed_s = 0.0;    // of bench time
  double remaining_s = 0.0;  // of bench time, NaN when unknown
  double pace = 1.0;         // bench seconds per second here
  std::string estimate;      // the latest, empty when there is none yet
};

class RunDisplay {
 public:
  virtual ~RunDisplay() = default;
  // A line that stays.
  virtual void Line(const std::string& text) = 0;
  // The state of now. To be called as often as one likes.
  virtual void Show(const RunView& view) = 0;
  // Takes away what is redrawn in place.
  virtual void Clear() = 0;
};

// One bar line of `view`, `columns` wide at most.
std::string BarLine(const RunView& view, int columns);
// The same without a bar.
std::string PlainLine(const RunView& view);

// On `stream` (stdout): the bar on a terminal, otherwise a line for each new segment, no more than
// one a second. With `quiet` nothing at all.
std::unique_ptr<RunDisplay> MakeRunDisplay(const presentation::Terminal& terminal, bool quiet);

}  // namespace gyrobench::cli
