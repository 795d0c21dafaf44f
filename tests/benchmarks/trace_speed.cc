// How long a trace takes, on one core: against the length of the recording, and many at once.
//
//   bench_trace_speed [--quick]
#include <fmt/format.h>
#include <sys/resource.h>

#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "calibration/trace/trace.h"
#include "tests/blind_trials/trial.h"

namespace {

using namespace gyrobench::blind_trials;
namespace calibration = gyrobench::calibration;

constexpr double kTarget_s = 3.0;  // 38 minutes, three channels

double Seconds(std::clock_t since) {
  return static_cast<double>(std::clock() - since) / CLOCKS_PER_SEC;
}

double PeakMemory_MB() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

struct Collected {
  calibration::Recording recording;
  double record_s = 0.0;  // simulating and collecting
};

// All three channels; `minutes` of the full sequence, over and over.
Collected Collect(double minutes, std::uint64_t run) {
  class Cut : public gyrobench::MeasurementSink {
   public:
    Cut(gyrobench::MeasurementSink& sink, double end_s) : sink_(sink), end_s_(end_s) {}
    void OnInfo(const gyrobench::MeasurementInfo& info) override { sink_.OnInfo(info); }
    void OnGyro(const gyrobench::GyroSample& s) override {
      if (s.t_s <= end_s_) sink_.OnGyro(s);
    }
    void OnCovariates(double t_s, std::span<const double> values) override {
      if (t_s <= end_s_) sink_.OnCovariates(t_s, values);
    }
    void OnAngle(const gyrobench::AngleSample& s) override {
      if (s.t_s <= end_s_) sink_.OnAngle(s);
    }
    void OnOrientation(const gyrobench::OrientationSample& s) override { sink_.OnOrientation(s); }
    void OnTickPair(const gyrobench::TickPair& pair) override {
      if (pair.host_s <= end_s_) sink_.OnTickPair(pair);
    }
    void OnSegment(const gyrobench::SegmentMark& mark) override {
      if (mark.end_s <= end_s_) sink_.OnSegment(mark);
    }
    void OnDefect(const gyrobench::Defect& defect) override { sink_.OnDefect(defect); }

   private:
    gyrobench::MeasurementSink& sink_;
    double end_s_;
  };
  const std::clock_t begin = std::clock();
  calibration::Collector collector;
  Cut cut(collector, 60.0 * minutes);
  TrialSpec spec = {
      .seed = 7, .run = run, .effects = {{"scale.cubic", kMid}}, .all_channels = true};
  spec.name = fmt::format("recording {}", run);
  spec.repeats = minutes > 40.0 ? 2 : 1;
  RecordTrial(spec, cut);
  return {collector.Take(), Seconds(begin)};
}

double Trace(const std::vector<const calibration::Recording*>& recordings) {
  const std::clock_t begin = std::clock();
  calibration::TraceOptions options;
  const calibration::Traced traced = calibration::Trace(recordings, options);
  const double seconds = Seconds(begin);
  if (traced.result.channels.size() != 3) fmt::print("expected three channels\n");
  return seconds;
}

void ByLength(bool quick) {
  fmt::print("{:<40} {:>9} {:>9} {:>9} {:>9} {:>11} {:>9}\n", "one sequence, 3 channels, 100 Hz",
             "samples", "nodes", "record s", "trace s", "us / sample", "peak MB");
  for (const double minutes : {19.0, 38.0, 76.0}) {
    if (quick && minutes > 20.0) break;
    const Collected collected = Collect(minutes, 7);
    const double trace_s = Trace({&collected.recording});
    const auto samples = static_cast<double>(collected.recording.samples);
    fmt::print("{:<40} {:>9.0f} {:>9} {:>9.2f} {:>9.2f} {:>11.2f} {:>9.0f}{}\n",
               fmt::format("{:.0f} min", minutes), samples,
               collected.recording.columns.nodes.size(), collected.record_s, trace_s,
               1e6 * trace_s / samples, PeakMemory_MB(),
               minutes == 38.0 ? fmt::format("  (target {:.0f} s)", kTarget_s) : "");
  }
}

void Together(int count) {
  std::vector<std::unique_ptr<Collected>> collected;
  std::vector<const calibration::Recording*> recordings;
  for (int i = 0; i < count; ++i) {
    collected.push_back(
        std::make_unique<Collected>(Collect(38.0, 100U + static_cast<std::uint64_t>(i))));
    recordings.push_back(&collected.back()->recording);
  }
  double one_s = 0.0;
  for (const auto* recording : recordings) one_s += Trace({recording}) / count;
  const double all_s = Trace(recordings);
  fmt::print("{:<40} {:>9.2f} s\n{:<40} {:>9.2f} s, {:.2f} times {:.0f}; peak {:.0f} MB\n",
             "one sequence alone, mean", one_s, fmt::format("{} sequences together", count), all_s,
             all_s / one_s / count, 1.0 * count, PeakMemory_MB());
}

}  // namespace

int main(int argc, char** argv) {
  const bool quick = argc > 1 && std::string(argv[1]) == "--quick";
  ByLength(quick);
  Together(quick ? 2 : 10);
  return 0;
}
