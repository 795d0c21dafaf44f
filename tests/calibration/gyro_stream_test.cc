#include "calibration/signal/gyro_stream.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace gyrobench::calibration {
namespace {

MeasurementInfo OneAxis(RateUnit unit = RateUnit::kLsb) {
  MeasurementInfo info;
  info.gyro_unit = unit;
  info.gyro_present = {true, false, false};
  return info;
}

GyroSample At(double t_s, double x) {
  GyroSample sample;
  sample.t_s = t_s;
  sample.xi[0] = x;
  return sample;
}

double CountsOfNoise() {
  static std::mt19937 random(5);
  return std::normal_distribution<double>(0.0, 5.0)(random);
}

std::int64_t Count(const GyroStream& stream, const std::string& kind) {
  std::int64_t count = 0;
  for (const Defect& defect : stream.defects()) {
    if (defect.kind == kind) count += defect.count;
  }
  return count;
}

bool IsBad(const GyroStream& stream, double t_s, std::size_t channel = 0) {
  for (const BadStretch& bad : stream.bad()) {
    if (bad.channel[channel] && bad.begin_s <= t_s && t_s <= bad.end_s) return true;
  }
  return false;
}

// The trapezoid rule is exact for a straight line, at the samples and in between.
TEST(GyroStream, IntegratesAStraightLineExactlyAtAnyTime) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i <= 100; ++i) stream.Add(At(0.01 * i, 3.0 + 20.0 * 0.01 * i));
  for (const double t : {0.0, 0.1234, 0.5, 0.777, 1.0}) {
    IntegralMark mark;
    ASSERT_TRUE(stream.IntegralAt(t, &mark));
    EXPECT_NEAR(mark.z[0], 3.0 * t + 10.0 * t * t, 1e-12);
  }
  IntegralMark mark;
  EXPECT_FALSE(stream.IntegralAt(1.001, &mark)) << "not yet measured";
}

// A swing of 0.5 Hz, sampled at about 50 Hz in one way or another.
double WorstErrorOfASwing(const std::function<double(int)>& interval_s) {
  const double k = 2.0 * std::numbers::pi * 0.5, rate = 100.0;
  GyroStream stream;
  stream.Start(OneAxis());
  double t_s = 0.0, worst = 0.0;
  for (int i = 0; i <= 1000; ++i, t_s += interval_s(i)) {
    stream.Add(At(t_s, rate * std::sin(k * t_s)));
    IntegralMark mark;
    for (const double part : {0.0, 0.3, 0.6}) {
      if (i < 10) continue;
      const double at_s = stream.settled_time_s() - part * 0.02;
      EXPECT_TRUE(stream.IntegralAt(at_s, &mark));
      worst = std::max(worst, std::fabs(mark.z[0] - rate / k * (1.0 - std::cos(k * at_s))));
    }
  }
  return worst;
}

// The trapezoid rule alone would be off by h^2 / 12 times the change of the acceleration: 0.02.
TEST(GyroStream, IntegratesASwingAsWellBySamplesOfUnequalDistanceAsByEqualOnes) {
  const double equal = WorstErrorOfASwing([](int) { return 0.02; });
  EXPECT_LT(equal, 2e-3);
  EXPECT_LT(WorstErrorOfASwing([](int i) { return i % 2 == 0 ? 0.005 : 0.035; }), 4e-3);
  EXPECT_LT(WorstErrorOfASwing([](int i) { return i < 500 ? 0.035 : 0.005; }), 4e-3);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> jitter(0.01, 0.03);
  EXPECT_LT(WorstErrorOfASwing([&](int) { return jitter(random); }), 4e-3);
}

TEST(GyroStream, ForgetsOldSamplesInsteadOfGuessing) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i <= 10000; ++i) stream.Add(At(0.005 * i, CountsOfNoise()));
  IntegralMark mark;
  EXPECT_FALSE(stream.IntegralAt(1.0, &mark));
  EXPECT_TRUE(stream.IntegralAt(49.0, &mark));
}

TEST(GyroStream, PutsASampleWithARepeatedStampBetweenItsNeighbours) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i <= 100; ++i) {
    // Sample 50 carries the stamp of sample 49.
    const double t = 0.01 * i, stamp = i == 50 ? 0.01 * 49 : t;
    stream.Add(At(stamp, 1000.0 * t * t));
  }
  IntegralMark mark;
  ASSERT_TRUE(stream.IntegralAt(1.0, &mark));
  EXPECT_NEAR(mark.z[0], 1000.0 / 3.0, 0.02) << "as if the stamp had been right";
  EXPECT_EQ(Count(stream, "repeated_time"), 1);
  EXPECT_TRUE(stream.bad().empty());
}

TEST(GyroStream, NeverGoesBackInTime) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i < 50; ++i) stream.Add(At(0.01 * i, CountsOfNoise()));
  stream.Add(At(0.2, 1e6));
  stream.Add(At(0.5, 0.0));
  EXPECT_EQ(Count(stream, "time_backwards"), 1);
  EXPECT_EQ(stream.last_time_s(), 0.5);
}

TEST(GyroStream, DoesNotIntegrateAcrossAGap) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i < 100; ++i) stream.Add(At(0.01 * i, 100 + CountsOfNoise()));
  for (int i = 200; i < 300; ++i) stream.Add(At(0.01 * i, 100 + CountsOfNoise()));
  EXPECT_EQ(Count(stream, "gap"), 1);
  EXPECT_TRUE(IsBad(stream, 1.5));
  EXPECT_FALSE(IsBad(stream, 0.5));
  EXPECT_FALSE(IsBad(stream, 2.5));
  IntegralMark mark;
  ASSERT_TRUE(stream.IntegralAt(2.99, &mark));
  EXPECT_NEAR(mark.z[0], 198.0, 3.0);
}

TEST(GyroStream, BridgesOneMissingValueAndMarksALongerStretch) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i < 300; ++i) {
    const bool missing = i == 50 || (i >= 150 && i < 170);
    stream.Add(At(0.01 * i, missing ? kMissing : 100 + CountsOfNoise()));
  }
  EXPECT_EQ(Count(stream, "not_a_number"), 21);
  EXPECT_FALSE(IsBad(stream, 0.5));
  EXPECT_TRUE(IsBad(stream, 1.6));
  IntegralMark mark;
  ASSERT_TRUE(stream.IntegralAt(2.9, &mark));
  EXPECT_TRUE(std::isfinite(mark.z[0]));
}

// With the value before in their place, the integral would be late by a part of an interval.
TEST(GyroStream, PutsMissingCellsOnTheLineOfTheirNeighbours) {
  std::mt19937_64 random(4);
  for (const double missing : {0.01, 0.05, 0.3}) {
    GyroStream stream;
    MeasurementInfo info = OneAxis();
    info.gyro_present = {true, true, true};
    stream.Start(info);
    std::bernoulli_distribution is_missing(missing);
    for (int i = 0; i <= 2000; ++i) {
      const double t_s = 0.01 * i;
      GyroSample sample = At(t_s, 1000.0 * t_s);
      sample.xi[1] = 5000.0 - 700.0 * t_s;
      sample.xi[2] = 500.0 * t_s;
      for (std::size_t c = 0; c < 2; ++c) {
        if (i % 3 != 0 && is_missing(random)) sample.xi[c] = kMissing;
      }
      stream.Add(sample);
    }
    IntegralMark mark;
    ASSERT_TRUE(stream.IntegralAt(19.9, &mark));
    EXPECT_NEAR(mark.z[0], 500.0 * 19.9 * 19.9, 1e-3) << missing;
    EXPECT_NEAR(mark.z[1], 5000.0 * 19.9 - 350.0 * 19.9 * 19.9, 1e-3) << missing;
    EXPECT_NEAR(mark.z[2], 250.0 * 19.9 * 19.9, 1e-3) << missing;
  }
}

TEST(GyroStream, TakesAxesOnRowsOfTheirOwn) {
  GyroStream stream;
  MeasurementInfo info = OneAxis();
  info.gyro_present = {true, true, true};
  stream.Start(info);
  for (int i = 0; i < 1000; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double t_s = 0.01 * i + 0.002 * static_cast<double>(axis);
      GyroSample sample = At(t_s, kMissing);
      sample.xi[axis] = 1000.0 * t_s;
      stream.Add(sample);
    }
  }
  IntegralMark begin, end;
  ASSERT_TRUE(stream.IntegralAt(1.0, &begin));
  ASSERT_TRUE(stream.IntegralAt(9.0, &end));
  for (std::size_t c = 0; c < 3; ++c)
    EXPECT_NEAR(end.z[c] - begin.z[c], 500.0 * (81.0 - 1.0), 1e-3) << c;
}

TEST(GyroStream, RecognisesAFrozenSensor) {
  GyroStream stream;
  MeasurementInfo info = OneAxis();
  info.gyro_present = {true, true, true};
  stream.Start(info);
  for (int i = 0; i < 600; ++i) {
    GyroSample sample = At(0.005 * i, std::round(CountsOfNoise()));
    sample.xi[1] = std::round(CountsOfNoise());
    sample.xi[2] = std::round(CountsOfNoise());
    if (i >= 200 && i < 400) sample.xi = {3, -2, 7};
    stream.Add(sample);
  }
  EXPECT_EQ(Count(stream, "frozen"), 200);
  EXPECT_TRUE(IsBad(stream, 1.001)) << "from its first repeated value on";
  EXPECT_TRUE(IsBad(stream, 1.9));
  EXPECT_FALSE(IsBad(stream, 0.9));
  EXPECT_FALSE(IsBad(stream, 2.1));
}

TEST(GyroStream, RecognisesSaturationAtTheLimitsOfSixteenBits) {
  GyroStream stream;
  stream.Start(OneAxis());
  for (int i = 0; i < 300; ++i) {
    stream.Add(At(0.01 * i, std::min(32767.0, 300.0 * i)));
  }
  EXPECT_EQ(Count(stream, "saturation"), 300 - 110);
  EXPECT_TRUE(IsBad(stream, 2.0));
  EXPECT_FALSE(IsBad(stream, 1.0));
}

TEST(GyroStream, RecognisesSaturationOfASensorThatScalesByItself) {
  GyroStream stream;
  stream.Start(OneAxis(RateUnit::kDegPerSecond));
  for (int i = 0; i < 1000; ++i) {
    stream.Add(
        At(0.01 * i, std::clamp(400.0 * std::sin(0.01 * i) + CountsOfNoise(), -250.1, 250.1)));
  }
  EXPECT_GT(Count(stream, "saturation"), 100);
  EXPECT_TRUE(IsBad(stream, 1.57)) << "at the peak";
  EXPECT_FALSE(IsBad(stream, 3.14));
}

TEST(GyroStream, ConvertsRadians) {
  GyroStream stream;
  stream.Start(OneAxis(RateUnit::kRadPerSecond));
  for (int i = 0; i <= 100; ++i) stream.Add(At(0.01 * i, 1.0 + 1e-6 * (i % 2)));
  IntegralMark mark;
  ASSERT_TRUE(stream.IntegralAt(1.0, &mark));
  EXPECT_NEAR(mark.z[0], 57.29578, 1e-3);
}

// Motion from 2 s on, braking from 3 s to 3.2 s.
TEST(GyroStream, FindsWhereMotionBeginsAndEnds) {
  GyroStream stream;
  stream.Start(OneAxis());
  auto rate = [](double t) {
    if (t < 2.0 || t > 3.2) return 0.0;
    if (t < 2.2) return (t - 2.0) * 80.0;
    return t < 3.0 ? 16.0 : (3.2 - t) * 80.0;
  };
  for (int i = 0; i < 1000; ++i)
    stream.Add(At(0.005 * i, 131.0 * rate(0.005 * i) + CountsOfNoise()));
  const double end = stream.RestEnd(2.02, 2.10), begin = stream.RestBegin(3.19);
  EXPECT_LE(end, 2.0);
  EXPECT_GT(end, 1.96);
  EXPECT_GE(begin, 3.2);
  EXPECT_LT(begin, 3.24);
}

}  // namespace
}  // namespace gyrobench::calibration
