// How good the estimators are, and how fast: many simulated runs through the door that real ones
// come through, next to the Cramer-Rao bound computed from dense Fisher information.
//
//   bench_estimators [--seeds N] [--quick]
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include "calibration/estimators/analyzer.h"
#include "tests/calibration/simulated_run.h"

namespace {

using gyrobench::calibration::AnalysisResult;
using gyrobench::calibration::Analyzer;
using namespace gyrobench::testing;

// Processor time: what else runs on the machine does not count.
double Seconds(std::clock_t since) {
  return static_cast<double>(std::clock() - since) / CLOCKS_PER_SEC;
}

struct Moments {
  double sum = 0, square = 0;
  int n = 0, missed = 0;
  void Add(double value) {
    if (!std::isfinite(value)) {
      ++missed;
      return;
    }
    sum += value;
    square += value * value;
    ++n;
  }
  double variance() const { return (square - sum * sum / n) / (n - 1); }
};

void ScaleCampaign(int seeds) {
  struct Line {
    const char* name;
    TurnSchedule schedule;
  };
  const std::vector<Line> lines = {
      {"20 deg/s,   9 deg,  1 turn", {20, 9, 1, false}},
      {"20 deg/s,   9 deg, 40 turns one way", {20, 9, 40, false}},
      {"20 deg/s,   9 deg, 40 turns back and forth", {20, 9, 40, true}},
      {"40 deg/s,   9 deg, 40 turns one way", {40, 9, 40, false}},
      {"40 deg/s, 360 deg, 10 turns one way", {40, 360, 10, false}},
  };
  const SimulatedSensor sensor;
  fmt::print(
      "Scale factor, {} runs a line. Standard deviation of the joint estimate over the Cramer-Rao "
      "bound;\n"
      "variance over the bound's square; share of 95 % intervals that hold the truth.\n\n",
      seeds);
  fmt::print("{:<44} {:>9} {:>10} {:>8} {:>8} {:>10} {:>10}\n", "schedule", "bound %", "joint std",
             "covers", "std/said", "eq.5 var", "1st rest");
  for (const Line& line : lines) {
    const double bound = ScaleBound(line.schedule, sensor);
    Moments joint, paper, first;
    double claimed = 0;
    int covered = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      Analyzer analyzer;
      SimulateTurns(line.schedule, sensor, static_cast<std::uint64_t>(seed), &analyzer);
      const AnalysisResult result = analyzer.Result();
      if (result.scale.size() != 1) {
        joint.Add(NAN);
        continue;
      }
      const auto& scale = result.scale.front();
      const double truth = sensor.alpha();
      joint.Add(scale.alpha / truth - 1);
      paper.Add(scale.paper_alpha / truth - 1);
      first.Add(scale.paper_first_rest_alpha / truth - 1);
      claimed += std::pow(scale.alpha_std_error / truth, 2) / seeds;
      if (std::fabs(scale.alpha - truth) <= 1.96 * scale.alpha_std_error) ++covered;
    }
    const double b2 = bound * bound;
    fmt::print("{:<44} {:>9.4f} {:>10.3f} {:>6.1f} % {:>8.2f} {:>10.2f} {:>10.2f}{}\n", line.name,
               100 * bound, std::sqrt(joint.variance() / b2), 100.0 * covered / seeds,
               std::sqrt(joint.variance() / claimed), paper.variance() / b2, first.variance() / b2,
               joint.missed > 0 ? fmt::format("  ({} without a result)", joint.missed) : "");
  }
}

void BiasCampaign(int seeds) {
  const SimulatedSensor sensor;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> size(0.5, 1.5);
  auto sign = [&] { return random() % 2 == 0 ? 1.0 : -1.0; };
  const double bound = CurveBound(WarmUp{}, sensor);
  double square = 0, claimed = 0, paper_square = 0;
  int covered = 0, points = 0;
  std::vector<int> orders(6);
  for (int seed = 1; seed <= seeds; ++seed) {
    WarmUp warm_up;
    warm_up.beta_deg_s = {sign() * size(random), sign() * 0.05 * size(random),
                          sign() * 0.003 * size(random), sign() * 0.0003 * size(random)};
    Analyzer analyzer;
    SimulateWarmUp(warm_up, sensor, static_cast<std::uint64_t>(seed), &analyzer);
    const auto bias = analyzer.Result().bias.at(0);
    ++orders.at(bias.coefficients.size() - 1);
    double run_square = 0, run_paper = 0;
    const int steps = 101;
    for (int i = 0; i < steps; ++i) {
      const double t =
          warm_up.Temperature(0) +
          (warm_up.Temperature(warm_up.duration_s) - warm_up.Temperature(0)) * i / (steps - 1);
      const double x = t - bias.reference_temperature_degC;
      auto curve = [&](const std::vector<double>& c) {
        double sum = 0;
        for (std::size_t j = c.size(); j-- > 0;) sum = sum * x + c[j];
        return sum / sensor.nominal_lsb_per_deg_s;
      };
      const double error = curve(bias.coefficients) - warm_up.Beta(t);
      run_square += error * error / steps;
      run_paper += std::pow(curve(bias.paper_coefficients) - warm_up.Beta(t), 2) / steps;
      if (i % 10 == 0) {
        double variance = 0;
        for (std::size_t a = 0; a < bias.coefficients.size(); ++a) {
          for (std::size_t b = 0; b < bias.coefficients.size(); ++b) {
            variance += bias.covariance[a][b] * std::pow(x, static_cast<double>(a + b));
          }
        }
        ++points;
        if (std::fabs(error) <= 1.96 * std::sqrt(variance) / sensor.nominal_lsb_per_deg_s)
          ++covered;
      }
    }
    square += run_square / seeds;
    paper_square += run_paper / seeds;
    claimed += std::pow(bias.rms_error / sensor.nominal_lsb_per_deg_s, 2) / seeds;
  }
  fmt::print(
      "\nBias against temperature, {} cold starts of 900 s, cubic beta(T), 22 to 38 degC.\n\n",
      seeds);
  fmt::print("{:<44} {:>10.6f} deg/s\n", "bound, RMS over the range", bound);
  fmt::print("{:<44} {:>10.3f} (of the standard error it states: {:.3f})\n",
             "joint estimate, RMS error / bound", std::sqrt(square) / bound,
             std::sqrt(square / claimed));
  fmt::print("{:<44} {:>10.3f}\n", "paper's estimate, RMS error / bound",
             std::sqrt(paper_square) / bound);
  fmt::print("{:<44} {:>8.1f} %\n", "95 % intervals of the curve cover", 100.0 * covered / points);
  fmt::print("{:<44} ", "orders chosen, 0 to 5");
  for (const int n : orders) fmt::print(" {}", n);
  fmt::print("\n");
}

void Speed(double hours) {
  TurnSchedule schedule;
  schedule.rest_s = 5.0;
  schedule.turns = static_cast<int>(hours * 3600.0 / (schedule.rest_s + schedule.TurnTime()));
  // Recorded first, so that the simulation is not timed.
  class Recorder final : public gyrobench::MeasurementSink {
   public:
    void OnInfo(const gyrobench::MeasurementInfo& info) override { info_ = info; }
    void OnGyro(const gyrobench::GyroSample& sample) override {
      order_.push_back(true);
      gyro_.push_back(sample);
    }
    void OnAngle(const gyrobench::AngleSample& sample) override {
      order_.push_back(false);
      angle_.push_back(sample);
    }
    void OnOrientation(const gyrobench::OrientationSample&) override {}
    void OnTickPair(const gyrobench::TickPair&) override {}
    void OnSegment(const gyrobench::SegmentMark&) override {}
    void OnDefect(const gyrobench::Defect&) override {}
    void PlayGyro(gyrobench::MeasurementSink* sink) const {
      sink->OnInfo(info_);
      for (const auto& sample : gyro_) sink->OnGyro(sample);
    }
    void Play(gyrobench::MeasurementSink* sink) const {
      sink->OnInfo(info_);
      std::size_t g = 0, a = 0;
      for (const bool gyro : order_) {
        if (gyro) {
          sink->OnGyro(gyro_[g++]);
        } else {
          sink->OnAngle(angle_[a++]);
        }
      }
    }
    std::size_t samples() const { return gyro_.size(); }

   private:
    gyrobench::MeasurementInfo info_;
    std::vector<bool> order_;
    std::vector<gyrobench::GyroSample> gyro_;
    std::vector<gyrobench::AngleSample> angle_;
  } recorder;
  SimulateTurns(schedule, SimulatedSensor{}, 1, &recorder);
  double best_feed = 1e9, best_gyro = 1e9, best_result = 1e9;
  for (int repeat = 0; repeat < 5; ++repeat) {
    Analyzer gyro_only;
    auto start = std::clock();
    recorder.PlayGyro(&gyro_only);
    best_gyro = std::min(best_gyro, Seconds(start));
    Analyzer analyzer;
    start = std::clock();
    recorder.Play(&analyzer);
    best_feed = std::min(best_feed, Seconds(start));
    start = std::clock();
    const AnalysisResult result = analyzer.Result();
    best_result = std::min(best_result, Seconds(start));
  }
  const double n = static_cast<double>(recorder.samples());
  fmt::print(
      "\nSpeed, {:.1f} h at 200 Hz, reference at 50 Hz ({} samples, {} turns), best of 5, "
      "processor time:\n"
      "{:.1f} ns a gyro sample, {:.1f} ns with its share of the readings; result in {:.3f} s.\n",
      hours, recorder.samples(), schedule.turns, best_gyro / n * 1e9, best_feed / n * 1e9,
      best_result);
}

}  // namespace

int main(int argc, char** argv) {
  int seeds = 200;
  bool quick = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    if (option == "--quick") {
      quick = true;
    } else if (option == "--seeds" && i + 1 < argc && std::atoi(argv[i + 1]) >= 2) {
      seeds = std::atoi(argv[++i]);
    } else {
      fmt::print(stderr, "usage: bench_estimators [--seeds N (2 or more)] [--quick]\n");
      return 2;
    }
  }
  if (quick) seeds = std::min(seeds, 20);
  const auto start = std::clock();
  ScaleCampaign(seeds);
  BiasCampaign(seeds);
  Speed(quick ? 0.2 : 1.0);
  fmt::print("The whole took {:.1f} s.\n", Seconds(start));
  return 0;
}
