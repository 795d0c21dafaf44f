#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json_text.h"
#include "calibration/artefact/trace_json.h"
#include "cli/calibration_files.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/files.h"
#include "cli/inputs.h"
#include "cli/traced_inputs.h"
#include "presentation/report.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;

void Print(const TracedInputs& inputs, const Options& options) {
  if (options.json) {
    fmt::print("{}\n", JsonText(calibration::ToJson(inputs.traced.result), 2));
  } else if (!options.quiet) {
    fmt::print("{}", presentation::RenderText(presentation::TraceDocument(inputs.traced.result),
                                              presentation::DescribeTerminal(fileno(stdout))));
  }
  std::fflush(stdout);
}

// With --json, stdout is the machine's.
void Say(const Options& options, const std::string& text) {
  if (!options.json && !options.quiet) fmt::print("{}\n", text);
}

void CheckTargets(const std::vector<InputFiles>& inputs, const Options& options) {
  std::vector<fs::path> taken = AllFiles(inputs);
  if (!options.calibration.empty()) CheckTarget("calibration", options.calibration, taken);
  if (!options.report.empty()) CheckTarget("report", options.report, taken);
  if (!options.report.empty() &&
      options.report.lexically_normal() == options.calibration.lexically_normal()) {
    throw UsageError(
        fmt::format("{}: calibration and report cannot be one file", options.report.string()));
  }
}

// Why no axis was traced, each reason once; empty where one was.
std::string WhyNothingWasTraced(const calibration::TraceResult& result) {
  std::string reasons;
  for (const calibration::ChannelTrace& channel : result.channels) {
    if (calibration::IsTraced(channel)) return "";
    if (reasons.find(channel.summary) == std::string::npos) reasons += ' ' + channel.summary;
  }
  for (const std::string& remark : result.remarks) reasons += ' ' + remark + '.';
  return "no axis could be traced, and there is no verdict." + reasons;
}

// How a trace ends once all that it says is written. Throws DataError where there is no verdict, or
// one of what cannot be.
int Judge(const TracedInputs& inputs) {
  const std::string why_nothing = WhyNothingWasTraced(inputs.traced.result);
  if (!why_nothing.empty()) throw DataError(why_nothing);
  if (!inputs.implausible.empty()) throw DataError(inputs.implausible.front());
  return kDone;
}

// Calibration and report, as far as they are wanted; `written` gets a line for each. Throws
// DataError where the data permit no calibration.
void WriteFiles(const TracedInputs& inputs, const Options& options,
                std::vector<std::string>* written) {
  for (const std::vector<std::string>* reasons : {&inputs.implausible, &inputs.two_clocks}) {
    if (options.calibration.empty() || reasons->empty()) continue;
    throw DataError(fmt::format("{}: no calibration is written; {}", options.calibration.string(),
                                reasons->front()));
  }
  const bool traced = WhyNothingWasTraced(inputs.traced.result).empty();
  const std::vector<HashedFile> hashed = options.calibration.empty() && options.report.empty()
                                             ? std::vector<HashedFile>()
                                             : HashFiles(inputs.inputs);
  if (!options.calibration.empty() && traced)
    written->push_back(
        WriteCalibration(MakeCalibration(inputs, hashed, options), options.calibration));
  if (options.report.empty()) return;
  const std::string line = TargetLine("report", options.report);
  presentation::WriteReport(MakeReportContent(inputs, hashed), options.report);
  written->push_back(line);
}

// Where the report of one input goes when nobody says.
fs::path ReportFile(const InputFiles& input, const Options& options) {
  if (!options.output.empty()) return options.output;
  if (input.on_disk.is_record) return input.on_disk.folder / recording::kReportName;
  throw UsageError(
      fmt::format("{} is a table: say where the report goes with -o FILE.html", options.name));
}

}  // namespace

int Trace(const Options& options) {
  const std::vector<InputFiles> files = LocateInputs(options.inputs, options);
  CheckTargets(files, options);
  const TracedInputs inputs = TraceInputs(files, options);
  // The files first, as who reads the text may stop in the middle of it; what keeps them from being
  // written is said behind it.
  std::exception_ptr failed;
  std::vector<std::string> written;
  try {
    WriteFiles(inputs, options, &written);
  } catch (const std::exception&) {
    failed = std::current_exception();
  }
  Print(inputs, options);
  for (const std::string& line : written) Say(options, line);
  if (failed) std::rethrow_exception(failed);
  return Judge(inputs);
}

int Report(const Options& options) {
  const std::vector<InputFiles> files = LocateInputs({options.name}, options);
  const fs::path file = ReportFile(files.front(), options);
  CheckTarget("report", file, AllFiles(files));
  const TracedInputs inputs = TraceInputs(files, options);
  const std::string line = TargetLine("report", file);
  presentation::WriteReport(MakeReportContent(inputs, HashFiles(inputs.inputs)), file);
  if (options.json) {
    fmt::print("{}\n", JsonText(nlohmann::json{{"report", file.string()}}, 2));
  } else {
    fmt::print("{}\n", line);
  }
  return Judge(inputs);
}

}  // namespace gyrobench::cli
