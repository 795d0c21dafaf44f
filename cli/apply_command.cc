#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "calibration/trace/calibration_file.h"
#include "cli/commands.h"
#include "cli/corrected_table.h"
#include "cli/effect_text.h"
#include "cli/exit_status.h"
#include "cli/inputs.h"
#include "cli/number_text.h"
#include "recording/file_hash.h"
#include "recording/run_directory.h"
#include "recording/table_writer.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// A record as a table that goes away again.
class ExportedTable {
 public:
  ExportedTable(const fs::path& record, const fs::path& output) : file_(output) {
    file_ += ".record.csv";
    recording::ExportTable(record, file_);
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

bool IsRecord(const fs::path& path) {
  return fs::is_directory(path) || path.filename() == recording::kRunJsonName ||
         path.filename() == recording::kEventLogName;
}

CorrectedTable Correct(const Options& options, const calibration::Calibration& calibration,
                       const fs::path& input) {
  const std::string made_by = fmt::format("gyrobench {} with {}, sha256 {}", kVersion,
                                          options.calibration.filename().string(),
                                          recording::Sha256OfFile(options.calibration));
  WorkBar bar(options.quiet);
  const auto progress = [&](double fraction) {
    bar.Show(fraction, "correcting " + input.filename().string());
  };
  const calibration::CorrectorOptions corrector{.any_sensor = options.any_sensor};
  if (!IsRecord(input)) {
    return WriteCorrectedTable(input, options.output, calibration, corrector, made_by, progress);
  }
  const ExportedTable table(input, options.output);
  return WriteCorrectedTable(table.file(), options.output, calibration, corrector, made_by,
                             progress);
}

Json ToJson(const CorrectedTable& table, const Options& options) {
  Json channels = Json::array();
  for (const calibration::ChannelCorrection& channel : table.correction.channels) {
    channels.push_back({{"gyro", std::string(1, "xyz"[static_cast<std::size_t>(channel.axis)])},
                        {"calibrated", channel.calibrated},
                        {"corrected", channel.corrected},
                        {"missing", channel.missing},
                        {"unsolved", channel.unsolved},
                        {"beyond_rate", channel.beyond_rate},
                        {"beyond_temperature", channel.beyond_temperature}});
  }
  return {{"table", options.output.string()},
          {"calibration", options.calibration.string()},
          {"rows", table.rows},
          {"rows_without_time", table.without_time},
          {"channels", channels},
          {"remarks", table.correction.remarks}};
}

std::string ChannelText(const calibration::ChannelCorrection& channel) {
  std::string text =
      fmt::format("  gyro {}: {} samples {}", "xyz"[static_cast<std::size_t>(channel.axis)],
                  FormatCount(channel.corrected),
                  channel.calibrated ? "corrected" : "over the nominal sensitivity");
  const auto add = [&](std::int64_t count, const char* what) {
    if (count > 0) text += fmt::format(", {} {}", FormatCount(count), what);
  };
  add(channel.missing, "without a value");
  add(channel.unsolved, "beyond all solution, left empty");
  add(channel.beyond_rate, "beyond the rates of the calibration");
  add(channel.beyond_temperature, "beyond its temperatures");
  return text + "\n";
}

void Print(const CorrectedTable& table, const Options& options) {
  const Terminal terminal = DescribeTerminal(fileno(stdout));
  fmt::print("{}: {} rows\n", options.output.string(), FormatCount(table.rows));
  for (const auto& channel : table.correction.channels) fmt::print("{}", ChannelText(channel));
  if (table.without_time > 0)
    fmt::print("  {} rows without a time, or of other length: left empty\n",
               FormatCount(table.without_time));
  const std::vector<std::string>& remarks = table.correction.remarks;
  for (auto remark = remarks.begin(); remark != remarks.end(); ++remark) {
    if (std::find(remarks.begin(), remark, *remark) != remark) continue;
    const auto times = std::count(remark, remarks.end(), *remark);
    const std::string note = times > 1 ? fmt::format(" ({} times)", times) : "";
    fmt::print("{}", Paragraph("! " + *remark + note, terminal, 2));
  }
}

}  // namespace

int Apply(const Options& options) {
  const calibration::Calibration calibration = calibration::CalibrationFromJson(
      recording::ReadJson(options.calibration), options.calibration.string());
  const fs::path input = LocateInput(options.name, options.bench);
  RefuseToReplace(options.output, options.overwrite);
  std::error_code absent;
  if (fs::equivalent(options.output, input, absent)) {
    throw DataError(
        fmt::format("{}: the corrected table would replace the measurement it is made of: "
                    "choose another name",
                    input.string()));
  }
  const CorrectedTable table = Correct(options, calibration, input);
  if (options.json) {
    fmt::print("{}\n", ToJson(table, options).dump(2));
  } else if (!options.quiet) {
    Print(table, options);
  }
  return kDone;
}

}  // namespace gyrobench::cli
