// From files to a trace: what `trace` and `report` share.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/collector.h"
#include "calibration/trace/calibration_file.h"
#include "calibration/trace/trace.h"
#include "cli/options.h"
#include "recording/measurement_files.h"
#include "report/report.h"

namespace gyrobench::cli {

struct InputFiles {
  std::filesystem::path path;  // of a table, or a record's folder
  recording::MeasurementFiles on_disk;
};

struct TracedInputs {
  std::vector<InputFiles> inputs;
  std::vector<calibration::Recording> recordings;
  std::string sensor;  // serial number, empty where no recording says it
  calibration::Traced traced;
  std::vector<std::string> implausible;  // scale factors that no part has, in words
};

// A file that was read.
struct HashedFile {
  std::size_t input = 0;  // index of TracedInputs::inputs
  std::filesystem::path path;
  std::string sha256;
};

// What `inputs` (runs, folders, tables) stand for on disk. Throws DataError or UsageError.
std::vector<InputFiles> LocateInputs(const std::vector<std::string>& inputs,
                                     const Options& options);
std::vector<std::filesystem::path> AllFiles(const std::vector<InputFiles>& inputs);

// Reads the inputs and traces them together, with a bar on stderr. Throws DataError: a file that
// cannot be read, or data of different sensors.
TracedInputs TraceInputs(const std::vector<InputFiles>& inputs, const Options& options);

// Of every file that was read (recording/measurement_files.h). Throws DataError.
std::vector<HashedFile> HashFiles(const TracedInputs& inputs);

// The artefact of a trace, with the hashes of its files.
calibration::Calibration MakeCalibration(const TracedInputs& inputs,
                                         const std::vector<HashedFile>& files,
                                         const Options& options);

// Trace, baseline (of a single input) and where they come from.
report::ReportContent MakeReportContent(const TracedInputs& inputs,
                                        const std::vector<HashedFile>& files);

}  // namespace gyrobench::cli
