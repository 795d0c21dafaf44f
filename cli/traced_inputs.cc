#include "cli/traced_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <numeric>
#include <optional>
#include <span>
#include <thread>

#include "base/error.h"
#include "base/version.h"
#include "calibration/estimators/analyzer.h"
#include "calibration/estimators/plausibility.h"
#include "calibration/signal/clock_drift.h"
#include "calibration/signal/clock_offset.h"
#include "calibration/signal/intake.h"
#include "cli/calibration_files.h"
#include "cli/inputs.h"
#include "recording/replay.h"
#include "recording/run_directory.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace gyrobench::cli {
namespace {

namespace fs = std::filesystem;

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

bool LacksSensitivity(const calibration::Recording& recording) {
  return recording.info.gyro_unit == RateUnit::kLsb && !recording.info.gyro_units_per_deg_s;
}

constexpr const char* kGiveSensitivity =
    "give the nominal sensitivity above the header, such as \"# gyro_lsb_per_deg_s = 131\"";

// Without a sensitivity turns of known angle may say it. At rest nothing does, and what is called
// deg/s would be LSB.
void RefuseWithoutScale(const std::vector<calibration::Recording>& recordings) {
  for (const calibration::Recording& recording : recordings) {
    if (!LacksSensitivity(recording) || recording.info.reference != ReferenceKind::kNone) return;
  }
  throw DataError(
      fmt::format("{}: the gyro is in LSB, its sensitivity is not given, and there is no reference "
                  "that could say it: {}; gyrobench analyze works in LSB without it; {}",
                  recordings.front().info.source, kGiveSensitivity,
                  calibration::WithoutReference(recordings.front().info)));
}

// What s0 was taken to be, where no input gives it.
void RemarkOnScale(TracedInputs* out) {
  for (const calibration::Recording& recording : out->recordings)
    if (!LacksSensitivity(recording)) return;
  auto& channels = out->traced.result.channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const calibration::ChannelModel& model = out->traced.models.at(i);
    const bool turned = model.m_row[static_cast<std::size_t>(model.axis)] != 0.0;
    channels[i].remarks.push_back(
        turned ? fmt::format("no input gives the sensitivity: s0 = {:.6g} LSB per deg/s is taken "
                             "from these data by the reference, so that the scale factor here is 1 "
                             "by choice and no error of the sensor; {}",
                             model.units_per_deg_s, kGiveSensitivity)
               : fmt::format("no input gives the sensitivity, and this axis never turned: its "
                             "figures are in LSB where they say deg/s; {}",
                             kGiveSensitivity));
  }
}

using calibration::Contradiction;

// Faults of each input, and scale factors of all of them together that no part has.
std::vector<Contradiction> ContradictionsTogether(const TracedInputs& inputs) {
  std::vector<Contradiction> out;
  const bool several = inputs.recordings.size() > 1;
  for (const calibration::Recording& recording : inputs.recordings) {
    for (const std::string& fault : calibration::FaultsIn(recording)) {
      out.push_back({{true, true, true},
                     fmt::format("{}this result cannot be: {}",
                                 several ? recording.info.source + ": " : std::string(), fault)});
    }
  }
  if (!out.empty() || !inputs.two_clocks.empty()) return out;
  std::vector<Defect> defects;
  for (const auto& input : inputs.traced.result.inputs)
    defects.insert(defects.end(), input.defects.begin(), input.defects.end());
  std::vector<const MeasurementInfo*> infos;
  for (const calibration::Recording& recording : inputs.recordings)
    infos.push_back(&recording.info);
  for (const calibration::ChannelModel& model : inputs.traced.models) {
    const auto axis = static_cast<std::size_t>(model.axis);
    const bool fitted = model.m_row_std_error[axis] > 0.0;
    const double ratio = fitted ? 1.0 / model.m_row[axis] : kMissing;
    if (!calibration::ImplausibleScale(ratio, model.axis, infos)) continue;
    std::string cause;
    for (const calibration::Recording& recording : inputs.recordings) {
      if (cause.empty()) cause = calibration::CauseIn(recording, model.axis);
    }
    out.push_back({{}, *calibration::ImplausibleScale(ratio, model.axis, infos, cause, defects)});
    out.back().axes[axis] = true;
  }
  return out;
}

// The same of each input alone, by its own unit, sensitivity, gear and defects.
std::vector<Contradiction> ContradictionsAlone(
    const std::vector<calibration::Recording>& recordings) {
  std::vector<Contradiction> out;
  for (const calibration::Recording& recording : recordings) {
    try {
      for (Contradiction& one : calibration::Contradictions(calibration::Analyze(recording))) {
        one.says = fmt::format("{}: {}", recording.info.source, one.says);
        out.push_back(std::move(one));
      }
    } catch (const DataError&) {  // alone it says nothing
    }
  }
  return out;
}

// Results that cannot be, said first. Of several inputs those are named that cannot be alone:
// together they need not differ by any factor that has a cause. Of clocks that were not started
// together no other cause is to be looked for.
void RemarkOnContradictions(TracedInputs* out) {
  std::vector<Contradiction> found = ContradictionsTogether(*out);
  if (found.empty()) return;
  std::vector<Contradiction> alone;
  if (out->recordings.size() > 1) alone = ContradictionsAlone(out->recordings);
  if (!alone.empty()) {
    // An axis that cannot be together may be well in each.
    for (const Contradiction& one : found)
      calibration::Condemn(one.axes, alone.front().says, &out->traced.result);
    found = std::move(alone);
  }
  for (auto one = found.rbegin(); one != found.rend(); ++one) {
    calibration::Condemn(one->axes, one->says, &out->traced.result);
    out->implausible.insert(out->implausible.begin(), one->says);
  }
  auto& remarks = out->traced.result.remarks;
  // What is said first is not said again.
  std::erase_if(remarks, [&](const std::string& remark) {
    return std::ranges::any_of(out->two_clocks, [&](const std::string& clocks) {
      return remark.ends_with(clocks) && out->implausible.front().ends_with(clocks);
    });
  });
  remarks.insert(remarks.begin(), out->implausible.begin(), out->implausible.end());
}

// "12.1, 35.4 degC": of each input, where it begins; empty where one has no temperature.
std::string StartTemperatures(const std::vector<calibration::Recording>& recordings) {
  std::string text;
  for (const calibration::Recording& recording : recordings) {
    const auto& nodes = recording.columns.nodes;
    const auto known = std::ranges::find_if(
        nodes, [](const auto& node) { return std::isfinite(node.temperature_degC); });
    if (known == nodes.end()) return "";
    text += fmt::format("{}{:.1f}", text.empty() ? "" : ", ", known->temperature_degC);
  }
  return text + " degC";
}

double FittedAngle_deg(const calibration::TraceResult& trace, SensorAxis axis) {
  for (const calibration::ChannelTrace& channel : trace.channels)
    if (channel.axis == axis) return channel.fitted_angle_rms_deg.after;
  return kMissing;
}

// Where effects do not account for all of several inputs, each is traced alone: inputs that fit
// well alone and badly together are not of one sensor in one state.
void RemarkOnInputsThatDoNotBelongTogether(TracedInputs* out, calibration::TraceOptions options) {
  constexpr double kMuchWorse = 2.0;
  options.try_on_rest = false;
  auto& channels = out->traced.result.channels;
  const auto is_open = [](const calibration::ChannelTrace& channel) {
    return channel.verdict == calibration::Verdict::kPartlyExplained ||
           channel.verdict == calibration::Verdict::kUnexplained;
  };
  if (out->recordings.size() < 2 || std::ranges::none_of(channels, is_open)) return;
  std::vector<calibration::TraceResult> alone;
  for (const calibration::Recording& recording : out->recordings) {
    const calibration::Recording* one = &recording;
    alone.push_back(calibration::Trace(std::span(&one, 1), options).result);
  }
  for (calibration::ChannelTrace& channel : channels) {
    if (!is_open(channel)) continue;
    double worst_deg = 0.0;
    for (const calibration::TraceResult& one : alone)
      worst_deg = std::fmax(worst_deg, FittedAngle_deg(one, channel.axis));
    const double together_deg = channel.fitted_angle_rms_deg.after;
    if (!(worst_deg > 0.0 && together_deg > kMuchWorse * worst_deg)) continue;
    const std::string temperatures = StartTemperatures(out->recordings);
    channel.remarks.push_back(fmt::format(
        "together the inputs fit worse than each alone: the angle error that the model leaves is "
        "{:.3g} deg, alone {:.3g} deg at most{}. From one to the next something changed that no "
        "effect here describes (power-on, temperature, mounting, settings): trace them apart",
        together_deg, worst_deg, temperatures.empty() ? "" : "; they begin at " + temperatures));
  }
}

// The files side by side, one for each core. Of several that cannot be read the first is complained
// of: every file before one that fails has been begun.
class Reader {
 public:
  Reader(const std::vector<InputFiles>& inputs, WorkBar& bar)
      : inputs_(inputs),
        bar_(bar),
        recordings_(inputs.size()),
        failures_(inputs.size()),
        fractions_(inputs.size()) {}

  std::vector<calibration::Recording> ReadAll() {
    ReadSideBySide([](std::size_t) { return true; });
    std::vector<calibration::RowTiming> timings;
    for (const calibration::Recording& recording : recordings_) timings.push_back(recording.rows);
    even_ = calibration::RowsThatComeEvenly(timings);
    if (std::ranges::any_of(even_, &calibration::EvenRows::any)) ReadAgain();
    return calibration::OnOneClock(std::move(recordings_), 0.0, [this](double drift_ppm) {
      for (calibration::EvenRows& even : even_) even.reference_drift_ppm = drift_ppm;
      recordings_ = std::vector<calibration::Recording>(inputs_.size());
      ReadSideBySide([](std::size_t) { return true; });
      return std::exchange(recordings_, {});
    });
  }

 private:
  // On even clocks; then, where rows are on a line, with the interval that it had at the end from
  // the begin on. Where the angle says that the times are no better for it, they stay as they were.
  void ReadAgain() {
    std::vector<calibration::Recording> first(recordings_.size());
    first.swap(recordings_);
    std::vector<bool> on_line;
    for (const calibration::EvenRows& even : even_) on_line.push_back(HasLine(even));
    ReadSideBySide([this](std::size_t file) { return even_[file].any(); });
    for (std::size_t i = 0; i < even_.size(); ++i) UseClocksOf(recordings_[i].rows, &even_[i]);
    ReadSideBySide([&](std::size_t file) { return on_line[file] && even_[file].any(); });
    for (std::size_t i = 0; i < even_.size(); ++i) {
      if (even_[i].any() && calibration::IsAsEvenAs(recordings_[i].rows, first[i].rows)) continue;
      recordings_[i] = std::move(first[i]);
      even_[i] = {};
    }
  }

  static bool HasLine(const calibration::EvenRows& even) {
    const auto known = [](const calibration::KnownClock& clock) {
      return std::isfinite(clock.interval_s);
    };
    return known(even.gyro) || std::ranges::any_of(even.reference, known);
  }

  static void UseClocksOf(const calibration::RowTiming& rows, calibration::EvenRows* even) {
    const auto use = [](const calibration::KnownClock& found, calibration::KnownClock* clock) {
      if (std::isfinite(clock->interval_s)) *clock = found;
    };
    use(rows.clocks.gyro, &even->gyro);
    for (std::size_t a = 0; a < 3; ++a) use(rows.clocks.reference[a], &even->reference[a]);
  }

  using IsWanted = std::function<bool(std::size_t file)>;
  void ReadSideBySide(const IsWanted& is_wanted) {
    next_ = 0;
    std::ranges::fill(fractions_, 0.0);
    const std::size_t cores = std::max(std::thread::hardware_concurrency(), 1U);
    {
      std::vector<std::jthread> others;
      for (std::size_t i = 1; i < std::min(cores, inputs_.size()); ++i)
        others.emplace_back([&] { ReadNext(is_wanted); });
      ReadNext(is_wanted);
    }
    for (const std::exception_ptr& failure : failures_)
      if (failure) std::rethrow_exception(failure);
  }

  void ReadNext(const IsWanted& is_wanted) {
    for (std::size_t i = next_++; i < inputs_.size(); i = next_++) {
      try {
        if (!is_wanted(i)) continue;
        recordings_[i] = Read(i, even_.empty() ? calibration::EvenRows{} : even_[i]);
      } catch (...) {
        failures_[i] = std::current_exception();
        next_ = inputs_.size();
      }
    }
  }

  calibration::Recording Read(std::size_t file, const calibration::EvenRows& even) {
    calibration::Collector collector(calibration::Collector::kNode_s, even);
    recording::Replay(inputs_[file].path, collector, [&](double f) { Show(file, f); });
    return collector.Take();
  }

  void Show(std::size_t file, double fraction) {
    const std::lock_guard lock(showing_);
    fractions_[file] = fraction;
    const double sum = std::accumulate(fractions_.begin(), fractions_.end(), 0.0);
    bar_.Show(
        sum / static_cast<double>(fractions_.size()),
        (even_.empty() ? "reading " : "reading again ") + inputs_[file].path.filename().string());
  }

  const std::vector<InputFiles>& inputs_;
  WorkBar& bar_;
  std::vector<calibration::Recording> recordings_;
  std::vector<std::exception_ptr> failures_;
  std::vector<double> fractions_;
  std::vector<calibration::EvenRows> even_;  // as the first reading shows; empty in it
  std::mutex showing_;
  std::atomic<std::size_t> next_ = 0;
};

// What was taken off the counts, as one table at least says it (the others give the same, or were
// centred by who logged them); empty of what is no count.
std::optional<double> CountOfZero(const std::vector<calibration::Recording>& recordings) {
  if (recordings.front().info.gyro_unit != RateUnit::kLsb) return std::nullopt;
  for (const calibration::Recording& recording : recordings)
    if (recording.info.gyro_lsb_zero) return recording.info.gyro_lsb_zero;
  return 0.0;
}

std::int64_t NowUtime() {
  return std::chrono::duration_cast<std::chrono::microseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

// Columns of all rows come and go by the thousand. The C library would give the memory of each back
// to the system, which clears every page before it gives it out again: of ten tables that took
// longer than any other part of their trace. All threads draw on one store, for what one of them
// has freed would be of no use to the others.
void KeepFreedMemory() {
#ifdef __GLIBC__
  mallopt(M_ARENA_MAX, 1);
  mallopt(M_MMAP_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
#endif
}

}  // namespace

TracedInputs TraceInputs(const std::vector<InputFiles>& inputs, const Options& options) {
  KeepFreedMemory();
  TracedInputs out;
  out.inputs = inputs;
  WorkBar bar(options.quiet);
  out.recordings = Reader(inputs, bar).ReadAll();
  out.sensor = SensorOf(out.recordings);
  RefuseWithoutScale(out.recordings);
  std::vector<const calibration::Recording*> all;
  for (const calibration::Recording& recording : out.recordings) all.push_back(&recording);
  calibration::TraceOptions trace;
  trace.seed = options.seed;
  trace.progress = [&](double fraction) { bar.Show(fraction, "tracing"); };
  out.traced = calibration::Trace(all, trace);
  trace.curves = false;
  trace.progress = [&](double) { bar.Show(1.0, "tracing each input alone"); };
  RemarkOnInputsThatDoNotBelongTogether(&out, trace);
  RemarkOnScale(&out);
  for (const calibration::Recording& recording : out.recordings) {
    if (std::string says = calibration::RemarkOnClocks(recording); !says.empty())
      out.two_clocks.push_back(std::move(says));
  }
  RemarkOnContradictions(&out);
  return out;
}

calibration::Calibration MakeCalibration(const TracedInputs& inputs,
                                         const std::vector<HashedFile>& files,
                                         const Options& options) {
  std::vector<InputExtent> extents;
  for (const calibration::Recording& recording : inputs.recordings)
    extents.push_back({recording.samples, recording.last_time_s - recording.first_time_s});
  calibration::Calibration calibration =
      BeginCalibration(inputs.sensor, inputs.inputs, files, extents);
  calibration.configuration["seed"] = std::to_string(options.seed);
  calibration.configuration["false_discovery"] =
      fmt::format("{}", calibration::TraceOptions{}.false_discovery);
  if (const std::string& says = inputs.traced.result.reference_error; !says.empty())
    calibration.configuration["reference_error"] = says;
  calibration.gyro_lsb_zero = CountOfZero(inputs.recordings);
  calibration.vector = inputs.traced.result.vector;
  const auto& channels = inputs.traced.result.channels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    calibration.channels.push_back({inputs.traced.models.at(i), channels[i].verdict,
                                    channels[i].heldout_whitened_rms,
                                    channels[i].heldout_angle_rms_deg, channels[i].noise});
  }
  return calibration;
}

presentation::ReportContent MakeReportContent(const TracedInputs& inputs,
                                              const std::vector<HashedFile>& files) {
  presentation::ReportContent content;
  content.trace = inputs.traced.result;
  if (inputs.recordings.size() == 1) content.analysis = calibration::Analyze(inputs.recordings[0]);
  presentation::Provenance& provenance = content.provenance;
  provenance.sensor = inputs.sensor;
  provenance.written_utime = NowUtime();
  if (const recording::MeasurementFiles& only = inputs.inputs[0].on_disk;
      inputs.inputs.size() == 1 && only.is_record)
    provenance.run = recording::ReadRunFacts(only.folder);
  for (const HashedFile& file : files) {
    provenance.files.push_back({file.path.filename().string(), file.sha256,
                                static_cast<std::int64_t>(fs::file_size(file.path))});
  }
  provenance.version = provenance.run.version.empty() ? kVersion : provenance.run.version;
  return content;
}

}  // namespace gyrobench::cli
