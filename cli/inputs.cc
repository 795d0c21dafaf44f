#include "cli/inputs.h"

#include <fmt/format.h>

#include <cstdio>

#include "cli/exit_status.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {

std::filesystem::path LocateInput(const std::string& input, const BenchOptions& bench) {
  std::error_code none;
  if (std::filesystem::exists(input, none)) return input;
  const bool is_path =
      input.find('/') != std::string::npos || input.find(".csv") != std::string::npos;
  if (is_path) throw DataError(fmt::format("{}: no such file", input));
  try {
    return recording::FindRun(BenchPlace(bench).Records(), input).folder();
  } catch (const UsageError& error) {
    throw UsageError(
        fmt::format("{} is no file, and as the name of a run: {}", input, error.what()));
  }
}

WorkBar::WorkBar(bool quiet)
    : terminal_(presentation::DescribeTerminal(fileno(stderr))),
      next_(Steady::now() + std::chrono::milliseconds(300)) {
  if (quiet) terminal_.redraws = false;
}

WorkBar::~WorkBar() {
  if (shown_) std::fputs("\r\x1b[K", stderr);
}

void WorkBar::Show(double fraction, const std::string& doing) {
  const Steady::time_point now = Steady::now();
  if (!terminal_.redraws || now < next_) return;
  next_ = now + std::chrono::milliseconds(100);
  const std::string line =
      fmt::format("{} {:3.0f} %  {}", presentation::Bar(fraction, 24), 100.0 * fraction, doing);
  fmt::print(stderr, "\r\x1b[K{}", presentation::Shorten(line, terminal_.columns - 1));
  shown_ = true;
}

}  // namespace gyrobench::cli
