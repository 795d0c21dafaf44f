#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "calibration/analyzer.h"
#include "calibration/result_json.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/result_text.h"
#include "cli/text_layout.h"
#include "recording/replay.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Steady = std::chrono::steady_clock;

// A bar on stderr, where that is a terminal and the reading takes long.
class ReadingBar {
 public:
  explicit ReadingBar(std::string name)
      : name_(std::move(name)), terminal_(DescribeTerminal(fileno(stderr))) {}
  ~ReadingBar() {
    if (shown_) std::fputs("\r\x1b[K", stderr);
  }
  ReadingBar(const ReadingBar&) = delete;
  ReadingBar& operator=(const ReadingBar&) = delete;

  void Show(double fraction) {
    const Steady::time_point now = Steady::now();
    if (!terminal_.redraws || now < next_) return;
    next_ = now + std::chrono::milliseconds(100);
    const std::string line =
        fmt::format("{} {:3.0f} %  reading {}", Bar(fraction, 24), 100.0 * fraction, name_);
    fmt::print(stderr, "\r\x1b[K{}", Shorten(line, terminal_.columns - 1));
    shown_ = true;
  }

 private:
  std::string name_;
  Terminal terminal_;
  Steady::time_point next_ = Steady::now() + std::chrono::milliseconds(300);
  bool shown_ = false;
};

// A path as it is; anything else is the name of a run.
std::filesystem::path Locate(const std::string& input, const BenchOptions& bench) {
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

Json AnalyzeOne(const std::filesystem::path& path) {
  calibration::Analyzer analyzer;
  {
    ReadingBar bar(path.filename().string());
    recording::Replay(path, analyzer, [&](double fraction) { bar.Show(fraction); });
  }
  return calibration::ToJson(analyzer.Result());
}

std::string Heading(const std::string& input, const Terminal& terminal) {
  const int rule = std::max(0, std::min(terminal.columns, 72) - DisplayWidth(input) - 4);
  std::string line = "── " + terminal.Bold(input) + " ";
  for (int i = 0; i < rule; ++i) line += "─";
  return line;
}

// The same quantity of several inputs, one under the other.
std::string Overview(const std::vector<std::string>& inputs, const std::vector<Json>& results) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    rows.push_back({inputs[i], ResultSummary(results[i])});
  return AlignColumns(rows, {Align::kLeft, Align::kLeft});
}

}  // namespace

int Analyze(const Options& options) {
  const Terminal terminal = DescribeTerminal(fileno(stdout));
  std::vector<std::string> inputs;
  std::vector<Json> results;
  for (const std::string& input : options.inputs) {
    const std::filesystem::path path = Locate(input, options.bench);
    try {
      results.push_back(AnalyzeOne(path));
    } catch (const DataError& error) {
      // The others are still worth reading.
      fmt::print(stderr, "gyrobench analyze: {}\n", error.what());
      continue;
    }
    inputs.push_back(input);
    if (options.json) continue;
    if (options.inputs.size() > 1) fmt::print("{}\n", Heading(input, terminal));
    fmt::print("{}{}", ResultText(results.back(), terminal), options.inputs.size() > 1 ? "\n" : "");
    std::fflush(stdout);
  }
  if (options.json && options.inputs.size() == 1 && !results.empty()) {
    fmt::print("{}\n", results.front().dump(2));
  } else if (options.json) {
    fmt::print("{}\n", Json(results).dump(2));
  } else if (results.size() > 1) {
    fmt::print("{}", Overview(inputs, results));
  }
  return results.size() == options.inputs.size() ? kDone : kFailed;
}

}  // namespace gyrobench::cli
