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
#include "report/report.h"

namespace gyrobench::cli {

struct TracedInputs {
  std::vector<std::filesystem::path> paths;  // of tables, or records' folders
  std::vector<calibration::Recording> recordings;
  calibration::Traced traced;
};

// Reads `inputs` (runs, folders, tables) and traces them together, with a bar on stderr. Throws
// DataError: a file that cannot be read, or data of different sensors.
TracedInputs TraceInputs(const std::vector<std::string>& inputs, const Options& options);

// The artefact of a trace, with the hashes of its files.
calibration::Calibration MakeCalibration(const TracedInputs& inputs, const Options& options);

// Trace, baseline (of a single input) and where they come from.
report::ReportContent MakeReportContent(const TracedInputs& inputs);

}  // namespace gyrobench::cli
