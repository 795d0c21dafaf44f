// calibration.json as commands write it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "cli/input_files.h"
#include "cli/options.h"

namespace gyrobench::cli {

// How much an input holds.
struct InputExtent {
  std::int64_t samples = 0;
  double duration_s = kMissing;
};

// What stands in every calibration, whichever method it is by: sensor, time, version, the files
// with their hashes. `extents`: of the inputs that `files` belong to, in their order.
calibration::Calibration BeginCalibration(const std::string& sensor,
                                          const std::vector<InputFiles>& inputs,
                                          const std::vector<HashedFile>& files,
                                          const std::vector<InputExtent>& extents);

// To where the options say, and says so unless stdout is the machine's.
void WriteCalibration(const calibration::Calibration& calibration, const Options& options);

}  // namespace gyrobench::cli
