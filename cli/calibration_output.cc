#include "cli/calibration_output.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <ctime>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "cli/targets.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;

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

void WriteCalibration(const calibration::Calibration& calibration, const Options& options) {
  const std::string line = TargetLine("calibration", options.calibration);
  recording::WriteJsonAtomically(options.calibration, calibration::ToJson(calibration));
  if (!options.json && !options.quiet) fmt::print("{}\n", line);
}

}  // namespace gyrobench::cli
