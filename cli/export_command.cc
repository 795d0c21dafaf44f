// `export`: a run as a measurement table, a calibration in the form that other programs take.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "base/part_file.h"
#include "base/version.h"
#include "cli/calibration_files.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/files.h"
#include "cli/terminal_text.h"
#include "export/exporter.h"
#include "presentation/text_layout.h"
#include "recording/measurement_files.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const exporting::Format& FormatOf(const Options& options) {
  if (const exporting::Format* found = exporting::FindFormat(options.format)) return *found;
  std::vector<std::string> names;
  for (const exporting::Format& format : exporting::Formats()) names.emplace_back(format.name);
  if (options.format.empty()) {
    throw UsageError(
        fmt::format("{} is a calibration: in which format? Expected --format with one of {}",
                    options.name, fmt::join(names, ", ")));
  }
  throw UsageError(fmt::format(
      "--format {}: there is no such format; a calibration is written in one of {}, and a run "
      "becomes a table, without --format",
      options.format, fmt::join(names, ", ")));
}

// The whole file or none.
void Write(const fs::path& file, const std::string& text) {
  PartFile part(file);
  part.Write(text);
  part.Replace();
}

int ExportCalibration(const Options& options) {
  const exporting::Format& format = FormatOf(options);
  const fs::path input = options.name;
  const calibration::Calibration calibration = ReadCalibration(input);
  CheckTarget(format.what, options.output, {input});
  RefuseToReplace(options.output, options.overwrite);
  const std::string line = TargetLine(format.what, options.output);
  const exporting::Exported exported =
      format.write(calibration, {input.filename().string(), recording::Sha256OfFile(input),
                                 kVersion, options.output.filename().string()});
  Write(options.output, exported.text);
  // Neither a machine nor a pipe may swallow them.
  for (const std::string& warning : exported.warnings) PrintError("export", "WARNING: " + warning);
  if (options.json) {
    fmt::print("{}\n", Json{{"file", options.output.string()},
                            {"format", format.name},
                            {"calibration", options.name},
                            {"notes", exported.notes}}
                           .dump(2));
    return kDone;
  }
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  fmt::print("{}\n", line);
  for (const std::string& note : exported.notes) {
    if (std::ranges::count(exported.warnings, note)) continue;
    fmt::print("{}", presentation::WrappedParagraph("! " + note, terminal, 2));
  }
  return kDone;
}

}  // namespace

int Export(const Options& options) {
  if (MeansCalibration(options.name)) return ExportCalibration(options);
  if (options.format.empty()) return ExportRecord(options);
  FormatOf(options);  // an unknown one is the first thing to be said
  throw UsageError(
      fmt::format("--format {} is for a calibration, and {} is none: expected the file that "
                  "`gyrobench trace ... --calibration` writes; a run becomes a table, without "
                  "--format",
                  options.format, options.name));
}

}  // namespace gyrobench::cli
