// Single wild samples of the gyro: bit errors, glitches of a bus. They are bridged and counted;
// what really moves never is.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "calibration/signal/collector.h"
#include "calibration/signal/gyro_stream.h"
#include "recording/replay.h"

namespace gyrobench::testing {
namespace {

using calibration::GyroStream;
using calibration::IntegralMark;

constexpr double kGyroInterval_s = 0.005;

MeasurementInfo Counts() {
  MeasurementInfo info;
  info.gyro_present = {true, false, false};
  info.gyro_units_per_deg_s = 131.0;
  return info;
}

std::int64_t Outliers(const std::vector<Defect>& defects) {
  std::int64_t count = 0;
  for (const Defect& defect : defects) count += defect.kind == "gyro_outlier" ? defect.count : 0;
  return count;
}

// Rest, a turn with 200 deg/s2 up to 120 deg/s, back at once, rest.
double Rate(double t_s) {
  if (t_s < 2.0 || t_s > 6.0) return 0.0;
  const double sign = t_s < 4.0 ? 1.0 : -1.0;
  const double in_turn_s = t_s < 4.0 ? t_s - 2.0 : t_s - 4.0;
  return sign * std::min({120.0, 200.0 * in_turn_s, 200.0 * (2.0 - in_turn_s)});
}

class WildSamples : public ::testing::Test {
 protected:
  // The run, with `wild` added to sample `where`; its integral at the end.
  double Run(std::size_t where, double wild, double sign_only = 1.0) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 4.0);
    stream_ = GyroStream();
    stream_.Start(Counts());
    for (std::size_t i = 0; i < 1600; ++i) {
      GyroSample sample;
      sample.t_s = 200.0 + kGyroInterval_s * static_cast<double>(i);
      sample.xi[0] = std::round(131.0 * sign_only * Rate(sample.t_s - 200.0) + noise(random));
      if (i == where) sample.xi[0] += wild;
      stream_.Add(sample);
    }
    IntegralMark mark;
    EXPECT_TRUE(stream_.IntegralAt(207.9, &mark));
    return mark.z[0];
  }
  GyroStream stream_;
};

TEST_F(WildSamples, AreBridgedAtRestAndInEveryKindOfMotion) {
  const double clean = Run(0, 0.0);
  EXPECT_EQ(Outliers(stream_.defects()), 0);
  // Among the first samples, at rest, at the begin of motion, at constant rate, in the reversal,
  // near the end.
  for (const std::size_t where : {11u, 100u, 300u, 400u, 420u, 600u, 799u, 801u, 1000u, 1500u}) {
    for (const double wild : {16384.0, -16384.0, 8192.0, 1e6}) {
      const double mended = Run(where, wild);
      EXPECT_EQ(Outliers(stream_.defects()), 1) << where << " " << wild;
      // What is left is the noise of one sample and the bend of the rate there.
      EXPECT_NEAR(mended, clean, kGyroInterval_s * 131.0 * 1.2) << where << " " << wild;
    }
  }
}

TEST_F(WildSamples, NeedEightBendsBeforeThemAndSmallOnesThirtyTwo) {
  // Two samples are needed for the first bend, and one more for the first that is judged.
  Run(10, 16384.0);
  EXPECT_EQ(Outliers(stream_.defects()), 1);
  Run(9, 16384.0);
  EXPECT_EQ(Outliers(stream_.defects()), 0);
  Run(20, 2000.0);
  EXPECT_EQ(Outliers(stream_.defects()), 0);
}

// 3000 deg/s2, at rest, on a ramp, at constant rate, while it slows down.
TEST_F(WildSamples, AreBridgedInMotionFromFortyBendsOn) {
  const double clean = Run(0, 0.0);
  for (const std::size_t where : {100u, 450u, 600u, 1140u, 1500u}) {
    const double mended = Run(where, 2000.0);
    EXPECT_EQ(Outliers(stream_.defects()), 1) << where;
    EXPECT_NEAR(mended, clean, kGyroInterval_s * 131.0 * 1.2) << where;
  }
}

// At 100 Hz a swing of the table goes further from sample to sample than a quarter of what a small
// wild sample is off by. What the other channels feel as well is a knock.
TEST_F(WildSamples, AreBridgedInASwingThatTheOtherChannelsDoNotFeel) {
  constexpr double kSwing_deg_s = 40.0, kSwing_Hz = 0.9, kSample_s = 0.01, kWild = 1300.0;
  MeasurementInfo info = Counts();
  info.gyro_present = {true, true, false};
  for (const int where : {500, 503, 545, 556, 560}) {
    for (const double knock : {0.0, 0.2}) {
      std::mt19937 random(13);
      std::normal_distribution<double> noise(0.0, 5.0);
      stream_ = GyroStream();
      stream_.Start(info);
      for (int i = 0; i < 1000; ++i) {
        GyroSample sample;
        sample.t_s = kSample_s * i;
        const double phase = 2.0 * std::numbers::pi * kSwing_Hz * sample.t_s;
        const double wild = i == where ? kWild : 0.0;
        sample.xi[0] = std::round(131.0 * kSwing_deg_s * std::sin(phase) + noise(random)) + wild;
        sample.xi[1] = std::round(noise(random) + knock * wild);
        stream_.Add(sample);
      }
      EXPECT_EQ(Outliers(stream_.defects()), knock == 0.0 ? 1 : 0) << where << ", " << knock;
    }
  }
}

// 200 deg/s2, which a hand reaches, but on all channels.
TEST_F(WildSamples, OfOneChannelAloneMayBeSmaller) {
  MeasurementInfo info = Counts();
  for (const bool others : {false, true}) {
    for (const double knock : {0.0, 0.5}) {
      info.gyro_present = {true, others, others};
      std::mt19937 random(17);
      std::normal_distribution<double> noise(0.0, 5.0);
      stream_ = GyroStream();
      stream_.Start(info);
      for (int i = 0; i < 1000; ++i) {
        GyroSample sample;
        sample.t_s = 0.01 * i;
        const double wild = i == 500 ? 2.0 * 131.0 : 0.0;
        sample.xi = {std::round(2000.0 + noise(random) + wild),
                     std::round(noise(random) + knock * wild),
                     std::round(noise(random) + knock * wild)};
        stream_.Add(sample);
      }
      EXPECT_EQ(Outliers(stream_.defects()), others && knock == 0.0 ? 1 : 0) << others << knock;
    }
  }
}

// A table that steps turns the sensor about no axis of its own alone.
TEST_F(WildSamples, OfOneChannelAloneMayComeAgain) {
  MeasurementInfo info = Counts();
  info.gyro_present = {true, true, true};
  for (const double felt_by_others : {0.0, 0.015}) {
    std::mt19937 random(19);
    std::normal_distribution<double> noise(0.0, 5.0);
    stream_ = GyroStream();
    stream_.Start(info);
    for (int i = 0; i < 1500; ++i) {
      GyroSample sample;
      sample.t_s = 0.01 * i;
      const double wild = i == 500 || i == 700 || i == 900 ? 46.0 * 131.0 : 0.0;
      sample.xi = {std::round(noise(random) + wild),
                   std::round(noise(random) + felt_by_others * wild), std::round(noise(random))};
      stream_.Add(sample);
    }
    EXPECT_EQ(Outliers(stream_.defects()), felt_by_others == 0.0 ? 3 : 1) << felt_by_others;
  }
}

// Between two samples the integral bends with the one after them: two before the newest it is
// settled.
TEST_F(WildSamples, AreKnownWithTheSampleAfterThem) {
  stream_.Start(Counts());
  std::mt19937 random(4);
  std::normal_distribution<double> noise(0.0, 4.0);
  for (int i = 0; i <= 100; ++i) {
    GyroSample sample;
    sample.t_s = kGyroInterval_s * i;
    sample.xi[0] = i == 100 ? 20000.0 : noise(random);
    stream_.Add(sample);
  }
  EXPECT_DOUBLE_EQ(stream_.settled_time_s(), kGyroInterval_s * 98);
  IntegralMark before, after;
  ASSERT_TRUE(stream_.IntegralAt(stream_.settled_time_s(), &before));
  GyroSample next;
  next.t_s = kGyroInterval_s * 101;
  next.xi[0] = 0.0;
  stream_.Add(next);
  EXPECT_EQ(Outliers(stream_.defects()), 1);
  ASSERT_TRUE(stream_.IntegralAt(before.t_s, &after));
  EXPECT_EQ(before.z[0], after.z[0]) << "what is settled does not change";
}

// A wild sample is no peak that the sensor may later saturate at.
TEST_F(WildSamples, DoNotHideASaturation) {
  MeasurementInfo info = Counts();
  info.gyro_unit = RateUnit::kDegPerSecond;
  stream_.Start(info);
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.03);
  for (int i = 0; i < 1200; ++i) {
    GyroSample sample;
    sample.t_s = kGyroInterval_s * i;
    const double rate = 400.0 * std::sin(kGyroInterval_s * i);
    sample.xi[0] = i == 60 ? 4000.0 : std::clamp(rate + noise(random), -250.0, 250.0);
    stream_.Add(sample);
  }
  EXPECT_EQ(Outliers(stream_.defects()), 1);
  bool saturation = false;
  for (const Defect& defect : stream_.defects()) {
    saturation = saturation || defect.kind == "saturation";
  }
  EXPECT_TRUE(saturation);
}

// Noise is not to be mended: it would look smaller than it is.
TEST_F(WildSamples, AreNotMadeOfHeavyTails) {
  constexpr int kSamples = 400'000;
  for (const double sigma : {4.0, 100.0, 400.0, 4000.0}) {
    stream_ = GyroStream();
    stream_.Start(Counts());
    std::mt19937 random(6);
    std::normal_distribution<double> noise(0.0, sigma);
    for (int i = 0; i < kSamples; ++i) {
      GyroSample sample;
      sample.t_s = kGyroInterval_s * i;
      sample.xi[0] = noise(random);
      if (random() % 100 == 0) sample.xi[0] = (random() % 2 == 0 ? 10.0 : -10.0) * sigma;
      stream_.Add(sample);
    }
    EXPECT_LT(Outliers(stream_.defects()), kSamples / 10'000) << sigma;
  }
}

TEST_F(WildSamples, AreNotMadeOfStepsOrPulsesOfMotion) {
  stream_.Start(Counts());
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 4.0);
  for (int i = 0; i < 4000; ++i) {
    GyroSample sample;
    sample.t_s = kGyroInterval_s * i;
    // A step in one sample, a knock that takes three, a ringing stepper.
    double rate = i > 1000 && i < 1500 ? 150.0 : 0.0;
    if (i >= 2000 && i < 2003) rate = 80.0;
    if (i > 2500) rate = 120.0 * std::exp(-0.02 * (i % 100)) * std::sin(2.1 * (i % 100));
    sample.xi[0] = 131.0 * rate + noise(random);
    stream_.Add(sample);
  }
  EXPECT_EQ(Outliers(stream_.defects()), 0);
}

// 300 to 5000 deg/s2: a sample that is 12 bends off where the rate is quiet is wild, once; what
// comes again soon, lasts longer or has a restless neighbour is motion.
TEST_F(WildSamples, AreSmallerOnesInQuietSurroundings) {
  struct Case {
    std::vector<std::pair<int, double>> wild;  // sample, deg/s
    std::int64_t outliers;
  };
  const Case cases[] = {
      {{{800, 3.0}}, 1},               // 600 deg/s2, 24 bends
      {{{800, 1.0}}, 0},               // 200 deg/s2: a hand does that
      {{{800, 3.0}, {801, 3.0}}, 0},   // two samples
      {{{799, 0.5}, {800, 3.0}}, 0},   // it grows
      {{{800, 3.0}, {2200, 3.0}}, 2},  // 7 s later
      {{{800, 3.0}, {1000, 3.0}}, 1},  // 1 s later: the second stays
  };
  for (const double rate_deg_s : {0.0, 60.0}) {
    for (const Case& one : cases) {
      std::mt19937 random(11);
      std::normal_distribution<double> noise(0.0, 4.0);
      stream_ = GyroStream();
      stream_.Start(Counts());
      for (int i = 0; i < 3000; ++i) {
        GyroSample sample;
        sample.t_s = kGyroInterval_s * i;
        sample.xi[0] = std::round(131.0 * rate_deg_s + noise(random));
        for (const auto& [where, wild_deg_s] : one.wild) {
          if (i == where) sample.xi[0] += 131.0 * wild_deg_s;
        }
        stream_.Add(sample);
      }
      EXPECT_EQ(Outliers(stream_.defects()), one.outliers)
          << one.wild.front().second << " deg/s, first of " << one.wild.size();
    }
  }
}

TEST(MeasuredData, HasNoWildSample) {
  const auto folder = std::filesystem::path(GYROBENCH_SOURCE_DIR) / "../shared/datasets";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no ../shared/datasets";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".gz") continue;
    calibration::Collector collector;
    recording::Replay(file.path(), collector);
    EXPECT_EQ(Outliers(collector.Take().defects), 0) << file.path();
  }
}

class GyroSamples final : public MeasurementSink {
 public:
  void OnInfo(const MeasurementInfo& info) override { info_ = info; }
  void OnGyro(const GyroSample& sample) override { samples_.push_back(sample); }
  void OnAngle(const AngleSample&) override {}
  void OnOrientation(const OrientationSample&) override {}
  void OnTickPair(const TickPair&) override {}
  void OnSegment(const SegmentMark&) override {}
  void OnDefect(const Defect&) override {}

  const MeasurementInfo& info() const { return info_; }
  const std::vector<GyroSample>& samples() const { return samples_; }

 private:
  MeasurementInfo info_;
  std::vector<GyroSample> samples_;
};

// In motion and at rest, the first samples of a recording know little of what is usual.
TEST(MeasuredData, HasNoWildSampleWhereverItBegins) {
  constexpr std::size_t kStride = 7, kFirst = 34;
  const auto folder = std::filesystem::path(GYROBENCH_SOURCE_DIR) / "../shared/datasets";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no ../shared/datasets";
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    if (file.path().extension() != ".gz") continue;
    GyroSamples measured;
    recording::Replay(file.path(), measured);
    std::int64_t outliers = 0;
    for (std::size_t begin = 0; begin + kFirst < measured.samples().size(); begin += kStride) {
      GyroStream stream;
      stream.Start(measured.info());
      for (std::size_t i = begin; i < begin + kFirst; ++i) stream.Add(measured.samples()[i]);
      outliers += Outliers(stream.defects());
    }
    EXPECT_EQ(outliers, 0) << file.path();
  }
}

}  // namespace
}  // namespace gyrobench::testing
