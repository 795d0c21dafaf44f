// Commands on recorded runs; no daemon is needed.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <ctime>
#include <utility>

#include "base/json_text.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/files.h"
#include "cli/inputs.h"
#include "cli/interrupt_watch.h"
#include "cli/json_field.h"
#include "cli/stored_results.h"
#include "cli/terminal_text.h"
#include "presentation/number.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "recording/measurement_files.h"
#include "recording/run_directory.h"
#include "recording/table_writer.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

// null where the file is absent; {"problem"} where it cannot be read: one damaged record must not
// hide the others.
Json ReadOr(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return nullptr;
  try {
    return recording::ReadJson(file);
  } catch (const DataError& error) {
    return {{"problem", error.what()}};
  }
}

// What the record says of its outcome; of a run whose daemon is gone nobody has said so in it yet.
std::string OutcomeIn(const Json& run, bool being_made) {
  std::string outcome = Text(run, recording::kOutcomeKey);
  const bool left_alone = outcome == recording::kRunningOutcome && !being_made;
  return left_alone ? recording::kInterruptedOutcome : outcome;
}

Json Describe(const recording::RunDirectory& run) {
  const bool being_made = run.IsBeingMade();  // before it is read
  const Json description = ReadOr(run.RunJson());
  return {{"run_id", run.run_id()},
          {"record", run.folder().string()},
          {"outcome", OutcomeIn(description, being_made)},
          {"run", description},
          {"result", ReadOr(run.ResultJson())},
          {"trace", ReadOr(run.folder() / recording::kTraceJsonName)}};
}

std::string OutcomeOf(const Json& record) {
  const Json& run = Field(record, "run");
  if (run.is_null()) return "no run.json";
  if (!Text(run, "problem").empty()) return "damaged run.json";
  const std::string outcome = Text(record, "outcome");
  if (outcome != Text(run, recording::kOutcomeKey))
    return outcome + " (its daemon is gone; the next start closes it)";
  return outcome.empty() ? "not closed" : outcome;
}

std::string LocalTime(const Json& run) {
  const std::int64_t utime = Integer(run, recording::kStartUtimeKey);
  if (utime == 0) return "-";
  return fmt::format("{:%Y-%m-%d %H:%M}",
                     fmt::localtime(static_cast<std::time_t>(utime / 1'000'000)));
}

void AddRow(std::vector<std::vector<std::string>>& rows, const std::string& name,
            const std::string& text) {
  if (!text.empty() && text != "-") rows.push_back({name, text});
}

std::string ParametersText(const Json& parameters) {
  std::string text;
  for (const auto& [name, value] : parameters.items()) {
    text += (text.empty() ? "" : ", ") + name + " = " + Plain(value);
  }
  return text;
}

// "aborted: by the operator", once: the message often begins with the outcome.
std::string OutcomeText(const Json& record) {
  const std::string outcome = OutcomeOf(record);
  const std::string message = Text(Field(record, "run"), "message");
  if (message.empty() || message.starts_with(outcome)) return message.empty() ? outcome : message;
  return outcome + ": " + message;
}

std::string HeadText(const Json& record, const presentation::Terminal& terminal) {
  const Json& run = Field(record, "run");
  std::vector<std::vector<std::string>> rows;
  AddRow(rows, "run", Text(record, "run_id"));
  AddRow(rows, "procedure", Text(run, "procedure"));
  if (Field(run, "parameters").is_object()) {
    AddRow(rows, "parameters", ParametersText(Field(run, "parameters")));
  }
  AddRow(rows, "began", LocalTime(run));
  AddRow(rows, "outcome", OutcomeText(record));
  AddRow(rows, "takes up", Text(run, recording::kResumedFromKey));
  AddRow(rows, "taken up by", Text(run, recording::kResumedByKey));
  AddRow(rows, "", Text(run, "problem"));
  AddRow(rows, "stand", Text(Field(run, "stand"), "name"));
  AddRow(rows, "record", Text(record, "record"));
  return WrappedColumns(rows, 2, terminal);
}

}  // namespace

int Runs(const Options& options) {
  const std::filesystem::path records = BenchPlace(options.bench).Records();
  Json list = Json::array();
  for (const auto& run : recording::ListRuns(records)) list.push_back(Describe(run));
  if (options.json) {
    fmt::print("{}\n", JsonText(Json{{"records", records.string()}, {"runs", list}}, 2));
    return kDone;
  }
  if (list.empty()) {
    fmt::print("no runs in {}; make one with: gyrobench run bias\n", records.string());
    return kDone;
  }
  using Kind = presentation::Column::Kind;
  presentation::Table table{{{}, {}, {}, {"", Kind::kNote}}, {}};
  for (const Json& record : list) {
    table.Add({Text(record, "run_id"), LocalTime(record["run"]), OutcomeOf(record),
               presentation::AnalysisSummary(ReadAnalysis(record["result"]))});
  }
  fmt::print("{}", presentation::RenderText({{std::move(table)}},
                                            presentation::DescribeTerminal(fileno(stdout))));
  return kDone;
}

namespace {

// A path needs no records folder, and so no stand file.
recording::RunDirectory FindRecord(const Options& options) {
  std::error_code none;
  if (std::filesystem::exists(options.name, none)) return recording::FindRun({}, options.name);
  return recording::FindRun(BenchPlace(options.bench).Records(), options.name);
}

}  // namespace

int Show(const Options& options) {
  const recording::RunDirectory run = FindRecord(options);
  const Json record = Describe(run);
  if (options.json) {
    fmt::print("{}\n", JsonText(record, 2));
    return kDone;
  }
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  const StoredTrace trace = ReadTrace(record["trace"]);
  presentation::Document document;
  fmt::print("{}", HeadText(record, terminal));
  const Json& result = record["result"];
  const std::string problem = Text(result, "problem");
  document = WiringDocument(Field(Field(record, "run"), recording::kWiringKey));
  if (!document.empty()) {
    fmt::print("\n{}", RenderText(document, terminal));
    return kDone;
  }
  if (result.is_null() || !problem.empty()) {
    fmt::print("\n{}: from the record itself: gyrobench analyze {}\n",
               problem.empty() ? "no results yet" : problem, Text(record, "run_id"));
  } else if (result.value("samples", Json()) == 0) {
    fmt::print("\nno results: the gyro gave no sample before the run ended\n");
  } else {
    document = presentation::AnalysisDocument(
        presentation::WithTraceRemarks(ReadAnalysis(result), trace.result));
  }
  Add(document, presentation::TraceSummary(trace.result, trace.not_known));
  if (!document.empty()) fmt::print("\n{}", RenderText(document, terminal));
  return kDone;
}

namespace {

recording::TableSummary WriteTable(const std::filesystem::path& record, const Options& options) {
  InterruptWatch interrupts;
  WorkBar bar(options.quiet);
  const auto progress = [&](double fraction) {
    interrupts.ThrowIfAsked("nothing was written");
    bar.Show(fraction, "writing " + options.output.filename().string());
  };
  const recording::TableSummary summary = recording::ExportTable(record, options.output, progress);
  interrupts.Take();  // too late: the table is there, and what is said of it is said
  return summary;
}

}  // namespace

int ExportRecord(const Options& options) {
  const recording::RunDirectory run = FindRecord(options);
  CheckTarget("table", options.output, recording::FilesOfMeasurement(run.folder()).files);
  RefuseToReplace(options.output, options.overwrite);
  const recording::TableSummary summary = WriteTable(run.folder(), options);
  if (options.json) {
    fmt::print("{}\n", Json{{"run_id", run.run_id()},
                            {"table", options.output.string()},
                            {"rows", summary.rows},
                            {"late", summary.late},
                            {"unannounced", summary.unannounced}}
                           .dump(2));
    return kDone;
  }
  fmt::print("{}: {} rows of run {}\n", options.output.string(),
             presentation::FormatCount(summary.rows), run.run_id());
  if (summary.late > 0) {
    fmt::print("  {} values left out: over {:g} s out of order\n",
               presentation::FormatCount(summary.late), recording::TableWriter::kReorder_s);
  }
  if (summary.unannounced > 0) {
    fmt::print("  {} values left out: of an axis that the record does not announce\n",
               presentation::FormatCount(summary.unannounced));
  }
  return kDone;
}

}  // namespace gyrobench::cli
