#include "daemon/run_trace.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "base/version.h"
#include "calibration/artefact/trace_json.h"
#include "calibration/effects/effect.h"
#include "calibration/trace/trace.h"
#include "presentation/report.h"
#include "recording/measurement_files.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

presentation::Provenance ProvenanceOf(const recording::RunDirectory& directory, const json& run) {
  presentation::Provenance provenance;
  provenance.run = recording::RunFactsFromJson(run);
  provenance.sensor = provenance.run.sensor;
  provenance.version = kVersion;
  provenance.written_utime = provenance.run.ended_utime;
  for (const auto& file : recording::FilesOfMeasurement(directory.folder()).files) {
    provenance.files.push_back({file.filename().string(), recording::Sha256OfFile(file),
                                static_cast<std::int64_t>(std::filesystem::file_size(file))});
  }
  return provenance;
}

}  // namespace

std::optional<calibration::Traced> TraceRun(const calibration::Recording& recording,
                                            TraceFor purpose) {
  calibration::TraceOptions options;
  options.curves = options.try_on_rest = purpose == TraceFor::kRecord;
  try {
    const calibration::Recording* one = &recording;
    return calibration::Trace(std::span(&one, 1), options);
  } catch (const DataError& error) {
    spdlog::info("nothing to trace: {}", error.what());
  } catch (const std::exception& error) {  // the record must be closed whatever the trace does
    spdlog::error("trace: {}", error.what());
  }
  return std::nullopt;
}

bool MayBeAStep(const calibration::TracedEffect& effect) {
  const auto is_step = [](const std::string& id) {
    const calibration::Effect* known = calibration::FindEffect(id);
    return known != nullptr && known->search == calibration::Search::kTime;
  };
  return is_step(effect.id) || std::ranges::any_of(effect.rivals, is_step);
}

procedures::AxisVerdict VerdictOf(const calibration::ChannelTrace& channel) {
  procedures::AxisVerdict verdict;
  verdict.axis = "xyz"[static_cast<std::size_t>(channel.axis)];
  verdict.verdict = Name(channel.verdict);
  verdict.summary = channel.summary;
  for (const calibration::TracedEffect& effect : channel.effects) {
    procedures::TracedEffect traced{effect.id,     Name(effect.owner), {},
                                    effect.rivals, effect.settled_by,  MayBeAStep(effect)};
    for (const calibration::ModelParameter& parameter : effect.parameters) {
      traced.parameters.push_back(
          {parameter.name, parameter.value, parameter.std_error, parameter.unit});
    }
    verdict.effects.push_back(std::move(traced));
  }
  return verdict;
}

void WriteTrace(const recording::RunDirectory& directory, const json& run,
                const calibration::TraceResult& trace,
                const calibration::AnalysisResult& analysis) {
  recording::WriteJsonAtomically(directory.folder() / recording::kTraceJsonName,
                                 calibration::ToJson(trace));
  try {
    presentation::ReportContent content;
    content.trace = trace;
    content.analysis = analysis;
    content.provenance = ProvenanceOf(directory, run);
    presentation::WriteReport(content, directory.folder() / recording::kReportName);
  } catch (const Error& error) {
    spdlog::warn("no report of {}: {}", directory.run_id(), error.what());
  }
}

}  // namespace gyrobench::daemon
