#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "calibration/trace/trace_json.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/inputs.h"
#include "cli/trace_text.h"
#include "cli/traced_inputs.h"
#include "recording/run_directory.h"
#include "report/reason.h"
#include "report/report.h"

namespace gyrobench::cli {
namespace {

void Print(const TracedInputs& inputs, const Options& options) {
  const nlohmann::json trace = calibration::ToJson(inputs.traced.result);
  if (options.json) {
    fmt::print("{}\n", trace.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (!options.quiet) {
    std::vector<double> rates_deg_s;
    for (const auto& channel : inputs.traced.result.channels)
      rates_deg_s.push_back(report::LargestRate_deg_s(channel));
    fmt::print("{}", TraceText(trace, DescribeTerminal(fileno(stdout)), rates_deg_s));
  }
  std::fflush(stdout);
}

// With --json, stdout is the machine's.
void Say(const Options& options, const std::string& text) {
  if (!options.json && !options.quiet) fmt::print("{}\n", text);
}

std::filesystem::path RecordFolder(const std::filesystem::path& path) {
  return std::filesystem::is_directory(path) ? path : path.parent_path();
}

}  // namespace

int Trace(const Options& options) {
  const TracedInputs inputs = TraceInputs(options.inputs, options);
  Print(inputs, options);
  if (options.calibration.empty() && options.report.empty()) return kDone;
  const std::vector<HashedFile> files = HashFiles(inputs);
  if (!options.calibration.empty()) {
    recording::WriteJsonAtomically(options.calibration,
                                   calibration::ToJson(MakeCalibration(inputs, files, options)));
    Say(options, fmt::format("calibration: {}", options.calibration.string()));
  }
  if (!options.report.empty()) {
    report::WriteReport(MakeReportContent(inputs, files), options.report);
    Say(options, fmt::format("report: {}", options.report.string()));
  }
  return kDone;
}

int Report(const Options& options) {
  const TracedInputs inputs = TraceInputs({options.name}, options);
  std::filesystem::path file = options.output;
  const bool is_table =
      std::filesystem::is_regular_file(inputs.paths[0]) &&
      !std::filesystem::exists(RecordFolder(inputs.paths[0]) / recording::kEventLogName);
  if (file.empty() && is_table) {
    throw UsageError(
        fmt::format("{} is a table: say where the report goes with -o FILE.html", options.name));
  }
  if (file.empty()) file = RecordFolder(inputs.paths[0]) / recording::kReportName;
  report::WriteReport(MakeReportContent(inputs, HashFiles(inputs)), file);
  if (options.json) {
    fmt::print("{}\n", nlohmann::json{{"report", file.string()}}.dump(2));
  } else {
    fmt::print("report: {}\n", file.string());
  }
  return kDone;
}

}  // namespace gyrobench::cli
