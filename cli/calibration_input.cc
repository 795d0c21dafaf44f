#include "cli/calibration_input.h"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "recording/measurement_files.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {

namespace fs = std::filesystem;

bool BeginsAsJson(const fs::path& file) {
  std::error_code none;
  char first = 0;
  if (fs::is_regular_file(file, none)) std::ifstream(file) >> first;
  return first == '{';
}

bool MeansCalibration(const fs::path& name) {
  std::error_code none;
  if (!fs::is_regular_file(name, none)) return false;
  const bool json = name.extension() == ".json" || BeginsAsJson(name);
  return json && !recording::FilesOfMeasurement(name).is_record;
}

calibration::Calibration ReadCalibration(const fs::path& file) {
  std::error_code none;
  if (fs::is_regular_file(file, none) && fs::file_size(file, none) == 0) {
    throw DataError(fmt::format(
        "{}: expected a calibration, found an empty file; a calibration is made with: gyrobench "
        "trace FILE... --calibration {}",
        file.string(), file.string()));
  }
  return calibration::CalibrationFromJson(recording::ReadJson(file), file.string());
}

}  // namespace gyrobench::cli
