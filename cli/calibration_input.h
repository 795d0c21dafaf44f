// A calibration as commands name it.
#pragma once

#include <filesystem>

#include "calibration/artefact/calibration_file.h"

namespace gyrobench::cli {

// Whether a file could be a calibration: JSON, to judge by its first character.
bool BeginsAsJson(const std::filesystem::path& file);

// Whether a name means a calibration's file, and not a record or a table: a plain file of JSON, by
// its name or first character, that is no part of a record. It need not be a sound one.
bool MeansCalibration(const std::filesystem::path& name);

// Throws DataError that names the file, the place in it and what was expected.
calibration::Calibration ReadCalibration(const std::filesystem::path& file);

}  // namespace gyrobench::cli
