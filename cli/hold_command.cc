#include <fmt/format.h>

#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "calibration/hold/calibrate_hold.h"
#include "calibration/hold/epoch_collector.h"
#include "cli/calibration_files.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "cli/files.h"
#include "cli/inputs.h"
#include "cli/terminal_text.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "recording/replay.h"

namespace gyrobench::cli {
namespace {

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
  std::vector<InputExtent> extents;
  for (const calibration::HoldInput& input : result.inputs)
    extents.push_back({input.samples, input.duration_s});
  calibration::Calibration calibration =
      BeginCalibration(result.sensor, inputs, HashFiles(inputs), extents);
  calibration.configuration["method"] = "held poses";
  calibration.configuration["g_sensitivity"] = options.g_sensitivity ? "asked for" : "when seen";
  calibration.channels = result.channels;
  calibration.gyro_lsb_zero = result.gyro_lsb_zero;
  calibration.vector = result.vector;
  return calibration;
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
  // Before the text, as who reads that may stop in the middle of it.
  std::string written;
  std::exception_ptr failed;
  try {
    if (!options.calibration.empty() && result.missing.empty())
      written = WriteCalibration(MakeCalibration(result, inputs, options), options.calibration);
  } catch (const std::exception&) {
    failed = std::current_exception();
  }
  if (options.json) {
    fmt::print("{}\n", JsonText(calibration::ToJson(result), 2));
  } else if (!options.quiet) {
    fmt::print("{}", presentation::RenderText(presentation::HoldDocument(result),
                                              presentation::DescribeTerminal(fileno(stdout))));
  }
  std::fflush(stdout);
  if (failed) std::rethrow_exception(failed);
  if (!result.missing.empty()) {
    if (options.json || options.quiet)
      for (const std::string& reason : result.missing)
        PrintError("hold", "no calibration: " + reason);
    return kFailed;
  }
  if (!written.empty() && !options.json && !options.quiet) fmt::print("{}\n", written);
  return kDone;
}

}  // namespace gyrobench::cli
