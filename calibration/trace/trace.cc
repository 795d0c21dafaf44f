#include "calibration/trace/trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.h"
#include "calibration/schedule.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/noise_search.h"
#include "calibration/trace/selection.h"
#include "calibration/trace/trail.h"

namespace gyrobench::calibration {
namespace {

// Columns that every measurement has and that are not constant in all of them.
std::vector<std::string> SharedCovariates(std::span<const Recording* const> recordings,
                                          std::vector<std::string>* remarks) {
  std::vector<std::string> out;
  std::set<std::string> dropped;
  for (const std::string& name : recordings.front()->info.covariates) {
    double low = kMissing, high = kMissing;
    bool everywhere = true;
    for (const Recording* recording : recordings) {
      const std::vector<std::string>& names = recording->info.covariates;
      const auto found = std::find(names.begin(), names.end(), name);
      everywhere = everywhere && found != names.end();
      if (!everywhere) break;
      bool any = false;
      for (auto i = static_cast<std::size_t>(found - names.begin());
           i < recording->columns.covariates.size(); i += names.size()) {
        const double value = recording->columns.covariates[i];
        low = std::fmin(low, value);
        high = std::fmax(high, value);
        any = any || std::isfinite(value);
      }
      everywhere = any;
    }
    if (everywhere && high > low) {
      out.push_back(name);
    } else {
      dropped.insert(name);
    }
  }
  for (const std::string& name : dropped) {
    remarks->push_back(fmt::format(
        "column {} is constant, empty or not in all files: nothing is traced to it", name));
  }
  return out;
}

TraceInput InputOf(const Recording& recording) {
  TraceInput input;
  input.file = recording.info.source;
  input.samples = recording.samples;
  input.duration_s = recording.samples > 0 ? recording.last_time_s - recording.first_time_s : 0.0;
  input.defects = recording.defects;
  return input;
}

// A record and the table that was exported from it are one measurement.
void CheckNotTwice(const Recording& recording, std::span<const Recording* const> recordings) {
  for (const Recording* other : recordings) {
    if (other == &recording) return;
    const std::vector<Node>&a = recording.columns.nodes, &b = other->columns.nodes;
    const bool same = recording.samples == other->samples && a.size() == b.size() && !a.empty() &&
                      a.back().at.z == b.back().at.z;
    if (!same) continue;
    throw DataError(fmt::format(
        "{} and {} hold the same measurement: give each once, twice it would count double",
        other->info.source, recording.info.source));
  }
}

void CheckUsable(std::span<const Recording* const> recordings) {
  if (recordings.empty()) throw DataError("nothing to trace: no measurement was given");
  for (const Recording* recording : recordings) {
    const std::string name =
        recording->info.source.empty() ? "measurement" : recording->info.source;
    if (recording->samples == 0) {
      throw DataError(
          fmt::format("{}: no gyro sample; expected a measurement with at least one axis", name));
    }
    bool any = false;
    for (std::size_t c = 0; c < 3; ++c)
      any = any || (recording->info.gyro_present[c] && recording->valid_samples[c] > 1);
    if (!any) {
      throw DataError(fmt::format(
          "{}: none of the {} gyro samples has a finite time and value; nothing can be estimated",
          name, recording->samples));
    }
    const double units = NominalUnitsPerDegPerS(recording->info);
    const double first_units = NominalUnitsPerDegPerS(recordings.front()->info);
    if (std::isfinite(units) && std::isfinite(first_units) &&
        std::fabs(units / first_units - 1.0) > 1e-6) {
      throw DataError(
          fmt::format("{}: {:.6g} units per deg/s, {} has {:.6g}: record with one range, or trace "
                      "them one by one",
                      name, units, recordings.front()->info.source, first_units));
    }
    CheckNotTwice(*recording, recordings);
    if (recording->info.gyro_unit != recordings.front()->info.gyro_unit) {
      throw DataError(
          fmt::format("{}: the gyro's unit is not that of {}; runs of one sensor are "
                      "traced together",
                      name, recordings.front()->info.source));
    }
  }
}

// s0: nominal where the measurement says; else what the data say, so that M is near 1.
double Units(std::span<const Recording* const> recordings, const std::vector<Vector3>& rough,
             std::size_t channel) {
  const double nominal = NominalUnitsPerDegPerS(recordings.front()->info);
  if (std::isfinite(nominal)) return nominal;
  for (const Vector3& sensitivity : rough) {
    if (std::isfinite(sensitivity[channel])) return std::fabs(sensitivity[channel]);
  }
  return 1.0;
}

}  // namespace

Traced Trace(std::span<const Recording* const> recordings, const TraceOptions& options) {
  CheckUsable(recordings);
  Traced out;
  std::vector<std::string>& remarks = out.result.remarks;
  const std::vector<std::string> covariates = SharedCovariates(recordings, &remarks);
  std::vector<Trail> trails;
  std::vector<Vector3> rough;
  std::set<std::string> power_ons;
  bool earth_rate_known = true;
  trails.reserve(recordings.size());
  for (const Recording* recording : recordings) {
    out.result.inputs.push_back(InputOf(*recording));
    rough.push_back(RoughSensitivity(*recording));
    const std::string& power_on = recording->info.power_on;
    const bool fresh = power_on.empty() || power_ons.insert(power_on).second;
    trails.push_back(MakeTrail(*recording, rough.back(), fresh, covariates));
    for (const std::string& remark : trails.back().remarks) remarks.push_back(remark);
    earth_rate_known = earth_rate_known && recording->info.site_latitude_deg.has_value();
  }
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < 3; ++c) {
    const bool present = std::any_of(recordings.begin(), recordings.end(), [c](const Recording* r) {
      return r->info.gyro_present[c] && r->valid_samples[c] > 1;
    });
    if (present) {
      channels.push_back(c);
    } else if (recordings.front()->info.gyro_present[c]) {
      remarks.push_back(fmt::format(
          "gyro {}: no sample has a finite value: not traced; is its column filled?", "xyz"[c]));
    }
  }
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const std::size_t c = channels[k];
    ChannelRequest request;
    request.trails = trails;
    request.channel = c;
    request.units_per_deg_s = Units(recordings, rough, c);
    request.covariates = covariates;
    request.earth_rate_known = earth_rate_known;
    request.false_discovery = options.false_discovery / static_cast<double>(channels.size());
    request.seed = options.seed + c;
    request.curves = options.curves;
    TracedChannel traced = TraceChannel(request);
    out.result.channels.push_back(std::move(traced.trace));
    out.models.push_back(std::move(traced.model));
    if (options.progress)
      options.progress(static_cast<double>(k + 1) / static_cast<double>(channels.size()));
  }
  return out;
}

}  // namespace gyrobench::calibration
