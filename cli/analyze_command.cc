#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "calibration/estimators/analyzer.h"
#include "calibration/estimators/plausibility.h"
#include "calibration/estimators/result_json.h"
#include "calibration/state/inputs_together.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/inputs.h"
#include "cli/terminal_text.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "recording/replay.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

calibration::AnalysisResult AnalyzeOne(const std::filesystem::path& path) {
  calibration::Analyzer analyzer;
  {
    WorkBar bar;
    const std::string doing = "reading " + path.filename().string();
    recording::Replay(path, analyzer, [&](double fraction) { bar.Show(fraction, doing); });
  }
  return analyzer.Result();
}

std::string Heading(const std::string& input, const presentation::Terminal& terminal) {
  const int rule =
      std::max(0, std::min(terminal.columns, 72) - presentation::DisplayWidth(input) - 4);
  std::string line = "── " + terminal.Bold(input) + " ";
  for (int i = 0; i < rule; ++i) line += "─";
  return line;
}

// The same quantity of several inputs, one under the other.
std::string Overview(const std::vector<std::string>& inputs,
                     const std::vector<calibration::AnalysisResult>& results) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    rows.push_back({inputs[i], presentation::AnalysisSummary(results[i])});
  return presentation::AlignColumns(rows, {presentation::Align::kLeft, presentation::Align::kLeft});
}

// Each input was analysed alone, so that its numbers hold; what contradicts another is said.
bool GoTogether(const std::vector<calibration::AnalysisResult>& analyses) {
  std::vector<calibration::InputSpan> inputs;
  for (const calibration::AnalysisResult& one : analyses)
    inputs.push_back({&one.info, one.first_time_s, one.first_time_s + one.duration_s});
  try {
    calibration::CheckPowerOns(inputs);
    return true;
  } catch (const DataError& error) {
    PrintError("analyze", error.what());
    return false;
  }
}

// What no part can have measured is an error, whatever else the analysis says.
bool CanBe(const calibration::AnalysisResult& analysis) {
  bool can_be = true;
  for (const std::string& one : calibration::Implausible(analysis)) {
    PrintError("analyze", fmt::format("{}: {}", analysis.info.source, one));
    can_be = false;
  }
  return can_be;
}

}  // namespace

int Analyze(const Options& options) {
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  std::vector<std::string> inputs;
  std::vector<calibration::AnalysisResult> analyses;
  for (const std::string& input : options.inputs) {
    const std::filesystem::path path = LocateInput(input, options.bench);
    try {
      analyses.push_back(AnalyzeOne(path));
    } catch (const DataError& error) {
      // The others are still worth reading.
      PrintError("analyze", error.what());
      continue;
    }
    inputs.push_back(input);
    if (options.json) continue;
    if (options.inputs.size() > 1) fmt::print("{}\n", Heading(input, terminal));
    fmt::print("{}{}", RenderText(presentation::AnalysisDocument(analyses.back()), terminal),
               options.inputs.size() > 1 ? "\n" : "");
    std::fflush(stdout);
  }
  if (options.json && options.inputs.size() == 1 && !analyses.empty()) {
    fmt::print("{}\n", JsonText(calibration::ToJson(analyses.front()), 2));
  } else if (options.json) {
    Json results = Json::array();
    for (const auto& one : analyses) results.push_back(calibration::ToJson(one));
    fmt::print("{}\n", JsonText(results, 2));
  } else if (analyses.size() > 1) {
    fmt::print("{}", Overview(inputs, analyses));
  }
  bool done = analyses.size() == options.inputs.size();
  for (const calibration::AnalysisResult& one : analyses) done = CanBe(one) && done;
  return GoTogether(analyses) && done ? kDone : kFailed;
}

}  // namespace gyrobench::cli
