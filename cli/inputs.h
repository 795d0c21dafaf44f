// Recorded data as commands name it, and the bar while it is read.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>

#include "cli/bench_place.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {

// A path as it is; anything else is the name of a run, whose record's folder is returned. Throws
// DataError when there is no such thing, UsageError when it is not told where records are.
std::filesystem::path LocateInput(const std::string& input, const BenchOptions& bench);

// A bar on stderr, where that is a terminal and the work takes long.
class WorkBar {
 public:
  explicit WorkBar(bool quiet = false);
  ~WorkBar();
  WorkBar(const WorkBar&) = delete;
  WorkBar& operator=(const WorkBar&) = delete;
  void Show(double fraction, const std::string& doing);

 private:
  using Steady = std::chrono::steady_clock;
  presentation::Terminal terminal_;
  Steady::time_point next_;
  bool shown_ = false;
};

}  // namespace gyrobench::cli
