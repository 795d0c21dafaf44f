#include "calibration/trace/trace.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "base/error.h"
#include "calibration/sensor/make_vector.h"
#include "calibration/signal/clock_offset.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/wrapped_counts.h"
#include "calibration/state/inputs_together.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/reference_angle_error.h"
#include "calibration/trace/shared_columns.h"
#include "calibration/trace/side_by_side.h"

namespace gyrobench::calibration {
namespace {

TraceInput InputOf(const Recording& recording) {
  TraceInput input;
  input.file = recording.info.source;
  input.samples = recording.samples;
  input.duration_s = recording.samples > 0 ? recording.last_time_s - recording.first_time_s : 0.0;
  input.defects = recording.defects;
  return input;
}

void CheckUsable(std::span<const Recording* const> recordings) {
  if (recordings.empty()) throw DataError("nothing to trace: no measurement was given");
  for (const Recording* recording : recordings) {
    const std::string name =
        recording->info.source.empty() ? "measurement" : recording->info.source;
    RefuseNoSamples(name, recording->samples, recording->defects,
                    "a measurement with at least one axis");
    RefuseWrappedCounts(name, recording->defects);
    bool any = false;
    for (std::size_t c = 0; c < 3; ++c)
      any = any || (recording->info.gyro_present[c] && recording->valid_samples[c] > 1);
    if (!any) {
      throw DataError(fmt::format(
          "{}: none of the {} gyro samples has a finite time and value; nothing can be estimated",
          name, recording->samples));
    }
    RefuseSamplesFarApart(*recording);
  }
  CheckTogether(recordings);
}

// s0: nominal where a measurement says; else what the data say, so that M is near 1.
double Units(std::span<const Recording* const> recordings, const std::vector<Vector3>& rough,
             std::size_t channel) {
  for (const Recording* recording : recordings) {
    const double nominal = NominalUnitsPerDegPerS(recording->info);
    if (std::isfinite(nominal)) return nominal;
  }
  for (const Vector3& sensitivity : rough) {
    if (std::isfinite(sensitivity[channel])) return std::fabs(sensitivity[channel]);
  }
  return 1.0;
}

void RemarkOnMissingReference(std::span<const Recording* const> recordings,
                              std::vector<std::string>* remarks) {
  const auto lacks = [](const Recording* r) { return r->info.reference == ReferenceKind::kNone; };
  if (!std::ranges::all_of(recordings, lacks)) return;
  remarks->push_back(
      "there is no reference angle (columns ref_inner_deg, ref_angle_z_deg, ref_qw and the like): "
      "the sensor is taken to be at rest, what moves is left out, and there is no scale factor; " +
      WithoutReference(recordings.front()->info));
}

void RemarkOnEarthRate(const std::vector<StateHistory>& histories,
                       std::vector<std::string>* remarks) {
  std::vector<std::string> known, unknown;
  for (const StateHistory& history : histories) {
    (history.earth_rate_known ? known : unknown).push_back(history.name);
    const MeasurementInfo& info = history.recording->info;
    if (history.earth_rate_known || !info.site_latitude_deg) continue;
    remarks->push_back(fmt::format(
        "{}: the site's latitude is given, but not how the sensor is oriented: Earth's rotation "
        "is not taken off",
        history.name));
  }
  if (known.empty() || unknown.empty()) return;
  remarks->push_back(fmt::format("Earth's rotation is taken off in {}, and not in {}",
                                 fmt::join(known, ", "), fmt::join(unknown, ", ")));
}

// Of one power-on in which the temperature goes one way alone, and does not stay where it has come
// to, time and temperature say the same: a polynomial of one describes what follows the other.
void RemarkOnTemperature(const std::vector<StateHistory>& histories,
                         std::vector<std::string>* remarks) {
  constexpr double kBack = 0.1;   // of the range: more is another way
  constexpr double kStays = 0.5;  // of the time
  std::vector<double> degC;       // node by node, some 10 a second
  for (const StateHistory& history : histories) {
    const bool other = history.new_power_on && &history != &histories.front();
    if (!history.temperature_known || other) return;
    for (const SensorState& node : history.nodes)
      if (std::isfinite(node.temperature_degC)) degC.push_back(node.temperature_degC);
  }
  if (degC.empty()) return;
  const double least = std::ranges::min(degC), most = std::ranges::max(degC);
  const double back = kBack * (most - least);
  double low = degC.front(), high = low, most_fallen = 0.0, most_risen = 0.0;
  for (const double now : degC) {
    low = std::min(low, now);
    high = std::max(high, now);
    most_fallen = std::max(most_fallen, high - now);
    most_risen = std::max(most_risen, now - low);
  }
  if (most - least < kLeastTemperatureRange_degC || std::min(most_fallen, most_risen) > back)
    return;
  const bool rose = most_risen > most_fallen;
  const auto at_end = std::ranges::count_if(
      degC, [&](double now) { return rose ? now > most - back : now < least + back; });
  if (static_cast<double>(at_end) > kStays * static_cast<double>(degC.size())) return;
  remarks->push_back(fmt::format(
      "the temperature only {}, from {:.1f} to {:.1f} degC: an offset that changes with the time "
      "since power-on, or with how fast the temperature changes, may pass here for one that "
      "depends on the temperature, and the other way round; measure while it {} as well to tell "
      "them apart",
      rose ? "rose" : "fell", rose ? least : most, rose ? most : least, rose ? "falls" : "rises"));
}

std::vector<std::size_t> ChannelsOf(std::span<const Recording* const> recordings,
                                    std::vector<std::string>* remarks) {
  std::vector<std::size_t> channels;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto announced = [c](const Recording* r) { return r->info.gyro_present[c]; };
    const auto filled = [c](const Recording* r) {
      return r->info.gyro_present[c] && r->valid_samples[c] > 1;
    };
    if (std::any_of(recordings.begin(), recordings.end(), filled)) {
      channels.push_back(c);
    } else if (std::any_of(recordings.begin(), recordings.end(), announced)) {
      remarks->push_back(fmt::format(
          "gyro {}: no sample has a finite value: not traced; is its column filled?", "xyz"[c]));
    }
  }
  return channels;
}

// Effects of columns that hardly change, but for those that were found all the same.
void AddUnidentifiable(const std::vector<Unidentifiable>& effects, ChannelTrace* trace) {
  for (const Unidentifiable& effect : effects) {
    const bool named =
        std::any_of(trace->effects.begin(), trace->effects.end(),
                    [&](const TracedEffect& found) { return found.id == effect.id; });
    if (!named) trace->unidentifiable.push_back(effect);
  }
}

// The measurements in an order of their own, so that the result does not depend on the order in
// which they were given.
struct Runs {
  std::vector<const Recording*> recordings;
  std::vector<Vector3> rough;
  std::vector<StateHistory> histories;
};

Runs MakeRuns(std::span<const Recording* const> recordings,
              const std::vector<std::string>& covariates, TraceResult* result) {
  Runs runs;
  const std::vector<OrderedRun> order = OrderRuns(recordings, &result->remarks);
  runs.rough.resize(order.size());
  runs.histories.resize(order.size());
  OnAllCores(order.size(), [&](std::size_t k) {
    const Recording& recording = *recordings[order[k].index];
    runs.rough[k] = RoughSensitivity(recording);
    runs.histories[k] = MakeStateHistory(recording, runs.rough[k], order[k].restart, covariates);
  });
  for (std::size_t k = 0; k < order.size(); ++k) {
    const OrderedRun& run = order[k];
    const Recording& recording = *recordings[run.index];
    runs.recordings.push_back(&recording);
    StateHistory& history = runs.histories[k];
    history.number = run.index + 1;
    if (!history.nodes.empty()) history.nodes.front().run = k + 1;
    std::vector<Defect>& defects = result->inputs[run.index].defects;
    defects.insert(defects.end(), history.defects.begin(), history.defects.end());
    for (const std::string& remark : history.remarks) result->remarks.push_back(remark);
    for (const std::string& remark : IntakeRemarks(recording))
      result->remarks.push_back(history.name + ": " + remark);
    if (const std::string clocks = RemarkOnClocks(recording); !clocks.empty())
      result->remarks.push_back(history.name + ": " + clocks);
  }
  RemarkOnEarthRate(runs.histories, &result->remarks);
  RemarkOnTemperature(runs.histories, &result->remarks);
  return runs;
}

// The channels of a sensor, traced until what one of them shows of the bench is known to all.
class SensorTrace {
 public:
  SensorTrace(std::vector<ChannelRequest> requests, const std::function<void(double)>& progress)
      : requests_(std::move(requests)), progress_(progress), traced_(requests_.size()) {}

  std::vector<TracedChannel> Run() {
    std::vector<std::size_t> all(requests_.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    TraceThese(all);
    TellEachOther();
    TakeOffMisreadAxes();
    if (progress_) progress_(1.0);
    return std::move(traced_);
  }

 private:
  void TraceThese(const std::vector<std::size_t>& which) {
    std::vector<const ChannelRequest*> some;
    for (const std::size_t k : which) some.push_back(&requests_[k]);
    std::vector<TracedChannel> results = TraceSideBySide(some, [&] {
      if (!progress_) return;
      progress_(std::min(1.0, ++done_ / static_cast<double>(requests_.size() + 1)));
    });
    for (std::size_t i = 0; i < which.size(); ++i) traced_[which[i]] = std::move(results[i]);
  }

  ReferenceAngleErrors AngleErrors() const {
    ReferenceAngleErrors errors;
    for (std::size_t k = 0; k < requests_.size(); ++k)
      errors[requests_[k].channel] = traced_[k].angle_error;
    return errors;
  }

  // Where one channel shows that an axis is read wrong, the others that are not clean are traced
  // again with that in view, and with its angle error in their cross-axis parts where they would
  // see it; and once more where the first then takes it back.
  void TellEachOther() {
    constexpr int kRounds = 2;
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<std::size_t> again = ToldMore(round);
      if (again.empty()) return;
      TraceThese(again);
    }
  }

  // Tells them, and says which channels have to be traced again for it.
  std::vector<std::size_t> ToldMore(int round) {
    std::vector<BenchFindings> own;
    std::vector<BenchFinding> errors;
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      own.push_back(Without(traced_[k].bench_findings, requests_[k].told));
      std::ranges::copy(own.back().found, std::back_inserter(errors));
      std::ranges::copy(own.back().supposed, std::back_inserter(errors));
    }
    const ReferenceAngleErrors angle_errors = AngleErrors();
    std::vector<std::size_t> again;
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      if (traced_[k].trace.verdict == Verdict::kNone) continue;
      std::vector<BenchFinding> now = NewTo(own[k], errors);
      std::vector<BenchFinding>& before = requests_[k].told;
      // What shakes the stand the channel names only where it is told.
      std::ranges::copy_if(before, std::back_inserter(now),
                           [](const BenchFinding& told) { return told.of_stand; });
      const bool told =
          round == 0 ? !now.empty() : NamesWhatIsGone(traced_[k].bench_findings, before, now);
      const bool new_errors = NeedsRetrace(requests_[k], traced_[k], angle_errors);
      if (!told && !new_errors) continue;
      requests_[k].sampling = traced_[k].sampling;
      if (told) before = std::move(now);
      if (new_errors) requests_[k].angle_errors = angle_errors;
      again.push_back(k);
    }
    return again;
  }

  // Last of all: a channel that can tell for itself that an axis is misread has named it by now.
  // Where that changes what is said of the axis, the channel stays as it was.
  void TakeOffMisreadAxes() {
    std::vector<std::size_t> again;
    std::vector<TracedChannel> before;
    for (std::size_t k = 0; k < requests_.size(); ++k) {
      std::vector<MisreadAxis> misread = MisreadByOthers(requests_, traced_, k);
      if (misread.empty()) continue;
      std::erase_if(requests_[k].told, [&](const BenchFinding& told) {
        return std::ranges::any_of(misread, [&](const MisreadAxis& axis) { return axis.Is(told); });
      });
      requests_[k].misread = std::move(misread);
      requests_[k].sampling = traced_[k].sampling;
      again.push_back(k);
      before.push_back(traced_[k]);
    }
    if (again.empty()) return;
    TraceThese(again);
    for (std::size_t i = 0; i < again.size(); ++i) {
      const std::size_t k = again[i];
      if (!AreTheSame(requests_[k].misread, MisreadByOthers(requests_, traced_, k)))
        traced_[k] = std::move(before[i]);
    }
  }

  std::vector<ChannelRequest> requests_;
  std::function<void(double)> progress_;
  std::vector<TracedChannel> traced_;
  double done_ = 0.0;  // channels
};

}  // namespace

Traced Trace(std::span<const Recording* const> recordings, const TraceOptions& options) {
  CheckUsable(recordings);
  Traced out;
  for (const Recording* recording : recordings) out.result.inputs.push_back(InputOf(*recording));
  RemarkOnMissingReference(recordings, &out.result.remarks);
  const SharedColumns columns = FindSharedColumns(recordings, &out.result.remarks);
  const Runs runs = MakeRuns(recordings, columns.names, &out.result);
  const std::vector<std::size_t> channels = ChannelsOf(recordings, &out.result.remarks);
  std::vector<ChannelRow> rows;
  std::vector<ChannelRequest> requests;
  for (const std::size_t c : channels) {
    ChannelRequest request;
    request.histories = runs.histories;
    request.channel = c;
    request.units_per_deg_s = Units(runs.recordings, runs.rough, c);
    request.covariates = columns.names;
    request.earth_rate_known =
        std::all_of(runs.histories.begin(), runs.histories.end(),
                    [](const StateHistory& t) { return t.earth_rate_known; });
    request.false_discovery = options.false_discovery / static_cast<double>(channels.size());
    request.seed = options.seed + c;
    request.curves = options.curves;
    request.try_on_rest = options.try_on_rest;
    requests.push_back(std::move(request));
  }
  std::vector<TracedChannel> traced_channels =
      SensorTrace(std::move(requests), options.progress).Run();
  for (std::size_t k = 0; k < channels.size(); ++k) {
    TracedChannel& traced = traced_channels[k];
    AddReferenceError(runs.histories, channels[k], &traced);
    AddEarthError(&traced);
    AddUnidentifiable(columns.unidentifiable, &traced.trace);
    out.result.channels.push_back(std::move(traced.trace));
    out.models.push_back(std::move(traced.model));
    rows.push_back(std::move(traced.row));
  }
  out.result.vector = MakeVectorCalibration(rows, runs.histories);
  DescribeReferenceError(runs.histories, &out.result);
  return out;
}

}  // namespace gyrobench::calibration
