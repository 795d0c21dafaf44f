#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/json_text.h"
#include "base/version.h"
#include "calibration/artefact/calibration_file.h"
#include "cli/calibration_files.h"
#include "cli/commands.h"
#include "cli/corrected_table.h"
#include "cli/exit_status.h"
#include "cli/files.h"
#include "cli/inputs.h"
#include "cli/interrupt_watch.h"
#include "presentation/number.h"
#include "presentation/text_layout.h"
#include "recording/measurement_files.h"
#include "recording/run_directory.h"
#include "recording/table_writer.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using calibration::ChannelCorrection;
using calibration::CorrectionReport;

// A record as a table that goes away again.
class ExportedTable {
 public:
  ExportedTable(const fs::path& record, const fs::path& output,
                const recording::ReplayProgress& progress)
      : file_(output) {
    file_ += ".record.csv";
    recording::ExportTable(record, file_, progress);
  }
  ~ExportedTable() {
    std::error_code ignored;
    fs::remove(file_, ignored);
  }
  ExportedTable(const ExportedTable&) = delete;
  ExportedTable& operator=(const ExportedTable&) = delete;
  const fs::path& file() const { return file_; }

 private:
  fs::path file_;
};

constexpr const char* kOrder = "gyrobench apply CALIBRATION.json TABLE.csv -o OUT.csv";

// What was given in place of a calibration, said before a parser stumbles over it.
void CheckOrder(const Options& options) {
  const fs::path& file = options.calibration;
  std::error_code none;
  if (!fs::exists(file, none)) {
    throw DataError(
        fmt::format("{}: no such file; expected a calibration, as `gyrobench trace FILE... "
                    "--calibration {}` writes it; the order is: {}",
                    file.string(), file.string(), kOrder));
  }
  const bool empty = fs::is_regular_file(file, none) && fs::file_size(file, none) == 0;
  if (empty || BeginsAsJson(file)) return;
  const bool swapped = BeginsAsJson(options.name);
  throw UsageError(
      fmt::format("{}: expected a calibration, found {}{}; the order is: {}", file.string(),
                  fs::is_directory(file, none) ? "a folder" : "no JSON, such as a table",
                  swapped ? ": calibration and table are swapped" : "", kOrder));
}

CorrectedTable Correct(const Options& options, const calibration::Calibration& calibration,
                       const fs::path& input) {
  const std::string made_by = fmt::format("gyrobench {} with {}, sha256 {}", kVersion,
                                          options.calibration.filename().string(),
                                          recording::Sha256OfFile(options.calibration));
  InterruptWatch interrupts;
  WorkBar bar(options.quiet);
  const auto shown = [&](const char* work) {
    return [&, work](double fraction) {
      interrupts.ThrowIfAsked("nothing was written");
      bar.Show(fraction, fmt::format("{} {}", work, input.filename().string()));
    };
  };
  const calibration::CorrectorOptions corrector{.any_sensor = options.any_sensor};
  std::optional<ExportedTable> exported;
  if (recording::FilesOfMeasurement(input).is_record)
    exported.emplace(input, options.output, shown("reading"));
  CorrectedTable corrected =
      WriteCorrectedTable(exported ? exported->file() : input, input.string(), options.output,
                          calibration, corrector, made_by, shown("correcting"));
  interrupts.Take();  // too late: the table is there, and what is said of it is said
  return corrected;
}

Json ToJson(const CorrectedTable& table, const Options& options) {
  Json channels = Json::array();
  for (const ChannelCorrection& channel : table.correction.channels) {
    channels.push_back({{"gyro", std::string(1, "xyz"[static_cast<std::size_t>(channel.axis)])},
                        {"calibrated", channel.calibrated},
                        {"corrected", channel.corrected},
                        {"missing", channel.missing},
                        {"unsolved", channel.unsolved},
                        {"beyond_rate", channel.beyond_rate},
                        {"largest_rate_deg_s", Number(channel.largest_rate_deg_s)},
                        {"beyond_temperature", channel.beyond_temperature},
                        {"lowest_degC", Number(channel.lowest_degC)},
                        {"highest_degC", Number(channel.highest_degC)}});
  }
  return {{"table", options.output.string()},
          {"calibration", options.calibration.string()},
          {"rows", table.rows},
          {"rows_without_time", table.without_time},
          {"samples", table.correction.samples},
          {"rows_outside", table.correction.outside},
          {"channels", channels},
          {"remarks", table.correction.remarks}};
}

std::string ChannelText(const ChannelCorrection& channel) {
  std::string text =
      fmt::format("  gyro {}: {} samples {}", "xyz"[static_cast<std::size_t>(channel.axis)],
                  presentation::FormatCount(channel.corrected),
                  channel.calibrated ? "corrected" : "over the nominal sensitivity");
  if (channel.missing > 0)
    text += fmt::format(", {} without a value", presentation::FormatCount(channel.missing));
  return text + "\n";
}

// "gyro z: 300 samples beyond 40 deg/s, up to 95.2; 20 samples outside of 20.0 to 40.0 degC, ..."
std::string BeyondText(const ChannelCorrection& channel) {
  std::vector<std::string> parts;
  if (channel.beyond_rate > 0) {
    parts.push_back(
        fmt::format("{} samples beyond the {:.3g} deg/s of the calibration, up to {:.3g}",
                    presentation::FormatCount(channel.beyond_rate), channel.max_rate_deg_s,
                    channel.largest_rate_deg_s));
  }
  if (channel.beyond_temperature > 0) {
    parts.push_back(fmt::format(
        "{} samples outside of its {:.1f} to {:.1f} degC, at {:.1f} to {:.1f}",
        presentation::FormatCount(channel.beyond_temperature), channel.min_temperature_degC,
        channel.max_temperature_degC, channel.lowest_degC, channel.highest_degC));
  }
  return fmt::format("{}", fmt::join(parts, "; "));
}

// What an operator must not miss, paragraph by paragraph; empty where all was within.
std::vector<std::string> Warnings(const CorrectionReport& report) {
  std::vector<std::string> texts;
  if (report.outside > 0) {
    texts.push_back(fmt::format(
        "WARNING: {} of {} samples ({:.1f} %) lie outside of what the calibration saw; there bias "
        "and effects are held at their values at its edge, and the errors are not known",
        presentation::FormatCount(report.outside), presentation::FormatCount(report.samples),
        100.0 * static_cast<double>(report.outside) / static_cast<double>(report.samples)));
  }
  for (const ChannelCorrection& channel : report.channels) {
    const char axis = "xyz"[static_cast<std::size_t>(channel.axis)];
    if (const std::string beyond = BeyondText(channel); !beyond.empty())
      texts.push_back(fmt::format("gyro {}: {}", axis, beyond));
  }
  for (const ChannelCorrection& channel : report.channels) {
    if (channel.unsolved == 0) continue;
    texts.push_back(fmt::format(
        "WARNING: gyro {}: {} samples left empty: the effects of the calibration have no solution "
        "there; trace data that reach these rates",
        "xyz"[static_cast<std::size_t>(channel.axis)],
        presentation::FormatCount(channel.unsolved)));
  }
  return texts;
}

// After all else; where stdout is a machine's or nobody's, on stderr.
void PrintWarnings(const CorrectionReport& report, const Options& options) {
  std::FILE* out = options.json || options.quiet ? stderr : stdout;
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(out));
  for (const std::string& warning : Warnings(report))
    fmt::print(out, "{}",
               terminal.Red(presentation::WrappedParagraph(warning, terminal,
                                                           warning.starts_with('W') ? 0 : 2)));
}

void Print(const CorrectedTable& table, const std::string& line) {
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  fmt::print("{}: {} rows\n", line, presentation::FormatCount(table.rows));
  for (const auto& channel : table.correction.channels) fmt::print("{}", ChannelText(channel));
  if (table.without_time > 0)
    fmt::print("  {} rows without a time, or of other length: left empty\n",
               presentation::FormatCount(table.without_time));
  const std::vector<std::string>& remarks = table.correction.remarks;
  for (auto remark = remarks.begin(); remark != remarks.end(); ++remark) {
    if (std::find(remarks.begin(), remark, *remark) != remark) continue;
    const auto times = std::count(remark, remarks.end(), *remark);
    const std::string note = times > 1 ? fmt::format(" ({} times)", times) : "";
    fmt::print("{}", presentation::WrappedParagraph("! " + *remark + note, terminal, 2));
  }
}

}  // namespace

int Apply(const Options& options) {
  CheckOrder(options);
  const calibration::Calibration calibration = ReadCalibration(options.calibration);
  const fs::path input = LocateInput(options.name, options.bench);
  std::vector<fs::path> read = recording::FilesOfMeasurement(input).files;
  read.push_back(options.calibration);
  CheckTarget("table", options.output, read);
  RefuseToReplace(options.output, options.overwrite);
  const std::string line = TargetLine("table", options.output);
  const CorrectedTable table = Correct(options, calibration, input);
  if (options.json) {
    fmt::print("{}\n", JsonText(ToJson(table, options), 2));
  } else if (!options.quiet) {
    Print(table, line);
  }
  PrintWarnings(table.correction, options);
  return kDone;
}

}  // namespace gyrobench::cli
