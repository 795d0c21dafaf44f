// From files to a trace: what `trace` and `report` share.
#pragma once

#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "calibration/signal/collector.h"
#include "calibration/trace/trace.h"
#include "cli/files.h"
#include "cli/options.h"
#include "presentation/report.h"

namespace gyrobench::cli {

struct TracedInputs {
  std::vector<InputFiles> inputs;
  std::vector<calibration::Recording> recordings;
  std::string sensor;  // serial number, empty where no recording says it
  calibration::Traced traced;
  std::vector<std::string> implausible;  // scale factors that no part has, in words
  std::vector<std::string> two_clocks;   // that were not started together, in words
};

// Reads the inputs and traces them together, with a bar on stderr. Throws DataError: a file that
// cannot be read, or data of different sensors.
TracedInputs TraceInputs(const std::vector<InputFiles>& inputs, const Options& options);

// The artefact of a trace, with the hashes of its files.
calibration::Calibration MakeCalibration(const TracedInputs& inputs,
                                         const std::vector<HashedFile>& files,
                                         const Options& options);

// Trace, baseline (of a single input) and where they come from.
presentation::ReportContent MakeReportContent(const TracedInputs& inputs,
                                              const std::vector<HashedFile>& files);

}  // namespace gyrobench::cli
