// A calibration as commands name, read and write it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "cli/files.h"
#include "cli/options.h"

namespace gyrobench::cli {

// Whether a file could be a calibration: JSON, to judge by its first character.
bool BeginsAsJson(const std::filesystem::path& file);

// Whether a name means a calibration's file, and not a record or a table: a plain file of JSON, by
// its name or first character, that is no part of a record. It need not be a sound one.
bool MeansCalibration(const std::filesystem::path& name);

// Throws DataError that names the file, the place in it and what was expected.
calibration::Calibration ReadCalibration(const std::filesystem::path& file);

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

// Returns what is to be said of it.
std::string WriteCalibration(const calibration::Calibration& calibration,
                             const std::filesystem::path& file);

}  // namespace gyrobench::cli
