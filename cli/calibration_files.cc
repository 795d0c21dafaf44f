#include "cli/calibration_files.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/version.h"
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

namespace {

// With the folder of a record: all records have files of the same names.
std::string NameOf(const HashedFile& file, const recording::MeasurementFiles& on_disk) {
  const fs::path folder =
      on_disk.is_record ? fs::weakly_canonical(on_disk.folder).filename() : fs::path();
  return (folder / file.path.filename()).string();
}

}  // namespace

calibration::Calibration BeginCalibration(const std::string& sensor,
                                          const std::vector<InputFiles>& inputs,
                                          const std::vector<HashedFile>& files,
                                          const std::vector<InputExtent>& extents) {
  calibration::Calibration calibration;
  calibration.sensor = sensor;
  calibration.created = fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", fmt::gmtime(std::time(nullptr)));
  calibration.version = kVersion;
  for (const HashedFile& file : files) {
    const InputExtent& extent = extents.at(file.input);
    calibration.inputs.push_back({NameOf(file, inputs.at(file.input).on_disk), file.sha256,
                                  extent.samples, extent.duration_s});
  }
  return calibration;
}

std::string WriteCalibration(const calibration::Calibration& calibration,
                             const std::filesystem::path& file) {
  std::string line = TargetLine("calibration", file);
  recording::WriteJsonAtomically(file, calibration::ToJson(calibration));
  return line;
}

}  // namespace gyrobench::cli
