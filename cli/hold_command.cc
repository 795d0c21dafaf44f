#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

#include "base/version.h"
#include "calibration/hold/calibrate_hold.h"
#include "calibration/hold/epoch_collector.h"
#include "calibration/hold/hold_json.h"
#include "calibration/trace/calibration_file.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/hold_text.h"
#include "cli/inputs.h"
#include "cli/targets.h"
#include "cli/traced_inputs.h"
#include "recording/file_hash.h"
#include "recording/replay.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;

std::vector<calibration::HoldRecording> ReadAll(const std::vector<InputFiles>& inputs,
                                                const Options& options) {
  std::vector<calibration::HoldRecording> recordings;
  WorkBar bar(options.quiet);
  for (const InputFiles& input : inputs) {
    calibration::EpochCollector collector;
    const std::string doing = "reading " + input.path.filename().string();
    recording::Replay(input.path, collector, [&](double fraction) { bar.Show(fraction, doing); });
    recordings.push_back(collector.Take());
  }
  return recordings;
}

calibration::Calibration MakeCalibration(const calibration::HoldResult& result,
                                         const std::vector<InputFiles>& inputs,
                                         const Options& options) {
  calibration::Calibration calibration;
  calibration.sensor = result.sensor;
  calibration.created = fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", fmt::gmtime(std::time(nullptr)));
  calibration.version = kVersion;
  calibration.configuration["method"] = "held poses";
  calibration.configuration["g_sensitivity"] = options.g_sensitivity ? "asked for" : "when seen";
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    for (const fs::path& file : inputs[i].on_disk.files)
      calibration.inputs.push_back({file.filename().string(), recording::Sha256OfFile(file),
                                    result.inputs[i].samples, result.inputs[i].duration_s});
  }
  calibration.channels = result.channels;
  calibration.gyro_lsb_zero = result.gyro_lsb_zero;
  calibration.vector = result.vector;
  return calibration;
}

void WriteCalibration(const calibration::HoldResult& result, const std::vector<InputFiles>& inputs,
                      const Options& options) {
  const std::string line = TargetLine("calibration", options.calibration);
  recording::WriteJsonAtomically(options.calibration,
                                 calibration::ToJson(MakeCalibration(result, inputs, options)));
  if (!options.json && !options.quiet) fmt::print("{}\n", line);
}

}  // namespace

int Hold(const Options& options) {
  const std::vector<InputFiles> inputs = LocateInputs(options.inputs, options);
  if (!options.calibration.empty())
    CheckTarget("calibration", options.calibration, AllFiles(inputs));
  const std::vector<calibration::HoldRecording> recordings = ReadAll(inputs, options);
  std::vector<const calibration::HoldRecording*> all;
  for (const calibration::HoldRecording& recording : recordings) all.push_back(&recording);
  const calibration::HoldResult result =
      calibration::CalibrateHold(all, {.g_sensitivity = options.g_sensitivity});
  const nlohmann::json json = calibration::ToJson(result);
  if (options.json) {
    fmt::print("{}\n", json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  } else if (!options.quiet) {
    fmt::print("{}", HoldText(json, DescribeTerminal(fileno(stdout))));
  }
  std::fflush(stdout);
  if (!result.missing.empty()) {
    if (options.json || options.quiet)
      for (const std::string& reason : result.missing)
        fmt::print(stderr, "gyrobench hold: no calibration: {}\n", reason);
    return kFailed;
  }
  if (!options.calibration.empty()) WriteCalibration(result, inputs, options);
  return kDone;
}

}  // namespace gyrobench::cli
