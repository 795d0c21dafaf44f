// What the blind trials rest on: a recording without anything hidden has no residual, and what is
// hidden is there, by formulas that neither the stand nor the tracer uses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/error.h"
#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {
namespace {

constexpr double kLsbPerDegS = 131.0;

// Integrates z as a table does (trapezoids) and compares with the inner axis' angle where z is its
// axis: while outer and middle stand still.
class IntegralAgainstAngle : public MeasurementSink {
 public:
  struct Point {
    double t_s = 0.0, angle_deg = 0.0, integral_deg = 0.0;
  };
  void OnInfo(const MeasurementInfo& info) override { info_ = info; }
  void OnGyro(const GyroSample& sample) override {
    const double w = sample.xi[2] / kLsbPerDegS;
    if (samples_ > 0) integral_deg_ += 0.5 * (w + last_w_) * (sample.t_s - last_t_s_);
    EXPECT_TRUE(samples_ == 0 || sample.t_s > last_t_s_);
    last_w_ = w;
    last_t_s_ = sample.t_s;
    last_degC_ = sample.temperature_degC;
    min_degC_ = std::min(min_degC_, sample.temperature_degC);
    max_degC_ = std::max(max_degC_, sample.temperature_degC);
    accel_g_ = sample.accel_g;
    ++samples_;
  }
  void OnCovariates(double, std::span<const double> values) override {
    covariates_ += values.size();
  }
  void OnAngle(const AngleSample& sample) override {
    angle_[static_cast<std::size_t>(sample.axis)] = sample.angle_deg;
    if (sample.axis != 2) return;
    // The sample of this very moment may come after the reading.
    const double since_s = samples_ > 0 ? sample.t_s - last_t_s_ : 0.0;
    points_.push_back({sample.t_s, angle_[2], integral_deg_ + since_s * last_w_});
    const double m = angle_[1] * std::numbers::pi / 180, i = angle_[2] * std::numbers::pi / 180;
    const std::array<double, 3> up = {std::sin(m) * std::sin(i), std::sin(m) * std::cos(i),
                                      std::cos(m)};
    for (std::size_t k = 0; k < 3 && samples_ > 0; ++k) {
      worst_gravity_g_ = std::max(worst_gravity_g_, std::fabs(up[k] - accel_g_[k]));
    }
  }
  void OnOrientation(const OrientationSample&) override { FAIL(); }
  void OnTickPair(const TickPair&) override {}
  void OnSegment(const SegmentMark&) override {}
  void OnDefect(const Defect& defect) override { FAIL() << defect.kind; }

  MeasurementInfo info_;
  std::array<double, 3> angle_ = {}, accel_g_ = {};
  std::vector<Point> points_;
  double integral_deg_ = 0.0, last_w_ = 0.0, last_t_s_ = 0.0, last_degC_ = 0.0;
  double min_degC_ = 1e9, max_degC_ = -1e9, worst_gravity_g_ = 0.0;
  std::int64_t samples_ = 0;
  std::size_t covariates_ = 0;
};

IntegralAgainstAngle Recorded(const TrialSpec& spec, TrialTruth* truth = nullptr) {
  IntegralAgainstAngle sink;
  const TrialTruth found = RecordTrial(spec, sink);
  if (truth != nullptr) *truth = found;
  return sink;
}

TEST(Recorder, TheIdealSequenceHasNoResidual) {
  const auto sink = Recorded({.seed = 11, .ideal = true});
  EXPECT_NEAR(sink.points_.back().t_s, 2262.0, 0.11);
  EXPECT_NEAR(static_cast<double>(sink.samples_), 226200, 12);
  const auto start = sink.points_.front();
  double worst = 0.0, path = 0.0, last = 0.0;
  for (const auto& point : sink.points_) {
    worst = std::max(worst, std::fabs(point.integral_deg - (point.angle_deg - start.angle_deg)));
    path += std::fabs(point.angle_deg - last);
    last = point.angle_deg;
  }
  EXPECT_GT(path, 9000.0);
  EXPECT_LT(worst, 4.5 * kDither_deg_sqrt_s * std::sqrt(2262.0) + 0.01);
  EXPECT_LT(sink.worst_gravity_g_, 40.0 * std::numbers::pi / 180 * 0.011);
}

TEST(Recorder, TheSensorWarmsUpIsCooledByTheFanAndWarmsUpAgain) {
  const auto sink = Recorded({.seed = 3, .ideal = true});
  EXPECT_NEAR(sink.min_degC_, 22.0, 0.1);
  EXPECT_NEAR(sink.max_degC_, 38.0, 0.1);
  EXPECT_LT(sink.last_degC_, 37.8);
}

TEST(Recorder, TheSameSeedGivesTheSameRecordingAndAnotherSeedAnother) {
  const TrialSpec poor = {.seed = 5, .sequence = SequenceKind::kBothWays};
  TrialSpec other = poor;
  other.seed = 6;
  const auto a = Recorded(poor), b = Recorded(poor), c = Recorded(other);
  EXPECT_EQ(a.integral_deg_, b.integral_deg_);
  EXPECT_NE(a.integral_deg_, c.integral_deg_);
}

// Mean of integral less angle at rest, over whole turns one way, per turn's rate: what a latency
// and a scale do is known without any model.
TEST(Recorder, ALatencyShowsWhileTurningAndNotAtRest) {
  const TrialSpec silent = {.seed = 8, .sequence = SequenceKind::kOneWay, .ideal = true};
  TrialSpec late = silent;
  late.effects = {{"angle.latency", kHigh}};
  const auto a = Recorded(silent), b = Recorded(late);
  ASSERT_EQ(a.points_.size(), b.points_.size());
  double moving = 0.0;
  int n = 0;
  for (std::size_t i = 1; i + 1 < a.points_.size(); ++i) {
    const double off = (b.points_[i].integral_deg - b.points_[i].angle_deg) -
                       (a.points_[i].integral_deg - a.points_[i].angle_deg);
    const double rate = (a.points_[i + 1].angle_deg - a.points_[i - 1].angle_deg) / 0.2;
    if (rate > 19.9) {
      moving += off / rate;
      ++n;
    } else if (rate == 0.0) {
      EXPECT_NEAR(off, 0.0, 0.1);
    }
  }
  ASSERT_GT(n, 1000);
  EXPECT_NEAR(std::fabs(moving / n), 3e-3, 3e-5);
}

TEST(Recorder, EveryEffectChangesTheRecording) {
  const TrialSpec silent = {.seed = 21, .ideal = true};
  const auto base = Recorded(silent);
  const auto change = [&](const std::string& id) {
    TrialSpec spec = silent;
    spec.effects = {{id, kLow}};
    const auto sink = Recorded(spec);
    double sum = 0.0;
    for (std::size_t i = 0; i < base.points_.size(); ++i) {
      sum += std::fabs(sink.points_[i].integral_deg - base.points_[i].integral_deg) +
             std::fabs(sink.points_[i].angle_deg - base.points_[i].angle_deg);
    }
    return sum;
  };
  for (const auto* list : {&CatalogueInjections(), &UnknownInjections()}) {
    for (const Injection& injection : *list) EXPECT_GT(change(injection.id), 0.0) << injection.id;
  }
  EXPECT_THROW(FindInjection("bias.nonsense"), DataError);
}

TEST(Recorder, TheMeasurementSaysNothingOfWhatIsHidden) {
  TrialTruth truth;
  const auto silent = Recorded({.seed = 31, .sequence = SequenceKind::kWarmUpOnly}, &truth);
  EXPECT_TRUE(truth.effects.empty());
  const auto hiding = Recorded(
      {.seed = 31, .sequence = SequenceKind::kWarmUpOnly, .effects = {{"bias.warm_up", kHigh}}},
      &truth);
  ASSERT_EQ(truth.effects.size(), 1U);
  EXPECT_EQ(silent.info_.source, hiding.info_.source);
  EXPECT_EQ(silent.info_.notes, hiding.info_.notes);
  EXPECT_EQ(silent.info_.covariates, hiding.info_.covariates);
}

}  // namespace
}  // namespace gyrobench::blind_trials
