#include "cli/traced_inputs.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/version.h"
#include "calibration/analyzer.h"
#include "cli/inputs.h"
#include "cli/json_field.h"
#include "recording/file_hash.h"
#include "recording/replay.h"
#include "recording/run_directory.h"

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> FilesOf(const fs::path& input) {
  std::error_code none;
  if (fs::is_regular_file(input, none)) return {input};
  std::vector<fs::path> files;
  for (const char* name : {recording::kEventLogName, recording::kRunJsonName}) {
    if (fs::exists(input / name, none)) files.push_back(input / name);
  }
  return files;
}

// The one sensor of all recordings: measurements of two parts are two problems.
std::string SensorOf(const std::vector<calibration::Recording>& recordings) {
  const MeasurementInfo* first = nullptr;
  for (const calibration::Recording& recording : recordings) {
    const MeasurementInfo& info = recording.info;
    if (info.sensor.empty()) continue;
    if (first == nullptr) first = &info;
    if (first->sensor != info.sensor) {
      throw DataError(fmt::format(
          "{} is of sensor {}, {} of sensor {}: only runs of one sensor can be traced together",
          first->source, first->sensor, info.source, info.sensor));
    }
  }
  return first == nullptr ? "" : first->sensor;
}

calibration::Recording Read(const fs::path& path, WorkBar& bar) {
  calibration::Collector collector;
  const std::string doing = "reading " + path.filename().string();
  recording::Replay(path, collector, [&](double fraction) { bar.Show(fraction, doing); });
  return collector.Take();
}

std::int64_t NowUtime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// What run.json says, where a record has one that can be read.
void AddRun(const fs::path& record, report::Provenance* provenance) {
  const fs::path file = record / recording::kRunJsonName;
  std::error_code none;
  if (!fs::exists(file, none)) return;
  try {
    const nlohmann::json run = recording::ReadJson(file);
    provenance->run_id = Text(run, recording::kRunIdKey);
    provenance->procedure = Text(run, "procedure");
    provenance->configuration = Text(Field(run, "stand"), "name");
    provenance->started_utime = Integer(run, recording::kStartUtimeKey);
    provenance->ended_utime = Integer(run, "end_utime");
    provenance->version = Text(run, "version");
    for (const auto& [name, value] : Field(run, "parameters").items())
      provenance->notes.emplace_back("parameter " + name, Plain(value));
  } catch (const DataError& error) {
    provenance->notes.emplace_back("run.json", error.what());
  }
}

}  // namespace

TracedInputs TraceInputs(const std::vector<std::string>& inputs, const Options& options) {
  TracedInputs out;
  WorkBar bar(options.quiet);
  for (const std::string& input : inputs) {
    out.paths.push_back(LocateInput(input, options.bench));
    out.recordings.push_back(Read(out.paths.back(), bar));
  }
  out.sensor = SensorOf(out.recordings);
  std::vector<const calibration::Recording*> all;
  for (const calibration::Recording& recording : out.recordings) all.push_back(&recording);
  calibration::TraceOptions trace;
  trace.seed = options.seed;
  trace.progress = [&](double fraction) { bar.Show(fraction, "tracing"); };
  out.traced = calibration::Trace(all, trace);
  return out;
}

std::vector<HashedFile> HashFiles(const TracedInputs& inputs) {
  std::vector<HashedFile> files;
  for (std::size_t i = 0; i < inputs.paths.size(); ++i) {
    for (const fs::path& file : FilesOf(inputs.paths[i]))
      files.push_back({i, file, recording::Sha256OfFile(file)});
  }
  return files;
}

calibration::Calibration MakeCalibration(const TracedInputs& inputs,
                                         const std::vector<HashedFile>& files,
                                         const Options& options) {
  calibration::Calibration calibration;
  calibration.sensor = inputs.sensor;
  calibration.created = fmt::format("{:%Y-%m-%dT%H:%M:%S}Z", fmt::gmtime(std::time(nullptr)));
  calibration.version = kVersion;
  calibration.configuration["seed"] = std::to_string(options.seed);
  calibration.configuration["false_discovery"] =
      fmt::format("{}", calibration::TraceOptions{}.false_discovery);
  for (const HashedFile& file : files) {
    const calibration::Recording& recording = inputs.recordings[file.input];
    const fs::path& input = inputs.paths[file.input];
    const fs::path folder =
        fs::equivalent(file.path, input) ? fs::path() : fs::weakly_canonical(input).filename();
    calibration.inputs.push_back({(folder / file.path.filename()).string(), file.sha256,
                                  recording.samples,
                                  recording.last_time_s - recording.first_time_s});
  }
  const auto& channels = inputs.traced.result.channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    calibration.channels.push_back({inputs.traced.models.at(i), channels[i].verdict,
                                    channels[i].heldout_whitened_rms,
                                    channels[i].heldout_angle_rms_deg});
  }
  return calibration;
}

report::ReportContent MakeReportContent(const TracedInputs& inputs,
                                        const std::vector<HashedFile>& files) {
  report::ReportContent content;
  content.trace = inputs.traced.result;
  if (inputs.recordings.size() == 1) content.analysis = calibration::Analyze(inputs.recordings[0]);
  report::Provenance& provenance = content.provenance;
  provenance.sensor = inputs.sensor;
  provenance.written_utime = NowUtime();
  if (inputs.paths.size() == 1) AddRun(inputs.paths[0], &provenance);
  for (const HashedFile& file : files) {
    provenance.files.push_back({file.path.filename().string(), file.sha256,
                                static_cast<std::int64_t>(fs::file_size(file.path))});
  }
  if (provenance.version.empty()) provenance.version = kVersion;
  return content;
}

}  // namespace gyrobench::cli
