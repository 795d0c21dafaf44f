// What is sampled beside the gyro is of the node's own time, whenever it came.
#include "calibration/signal/beside_gyro.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "calibration/signal/collector.h"

namespace gyrobench::testing {
namespace {

using calibration::BesideGyro;
using calibration::Collector;
using calibration::Recording;

constexpr double kSample_s = 0.01, kReading_s = 0.1;

MeasurementInfo OneAxis() {
  MeasurementInfo info;
  info.gyro_present = {false, false, true};
  info.gyro_unit = RateUnit::kDegPerSecond;
  info.reference = ReferenceKind::kSensorAngle;
  info.reference_axis = SensorAxis::kZ;
  info.temperature_present = true;
  info.covariates = {"clock_s"};
  return info;
}

// A thermometer and a column that show the time itself.
void Sample(double t_s, Collector* collector) {
  GyroSample sample;
  sample.t_s = t_s;
  sample.xi = {kMissing, kMissing, 5.0};
  sample.temperature_degC = t_s;
  collector->OnGyro(sample);
  collector->OnCovariates(t_s, std::span(&t_s, 1));
}

void Read(double t_s, Collector* collector) {
  AngleSample reading;
  reading.t_s = t_s;
  reading.axis = static_cast<int>(SensorAxis::kZ);
  reading.angle_deg = 5.0 * t_s;
  collector->OnAngle(reading);
}

// `ahead`: of readings, samples that come before them.
Recording Record(int ahead) {
  Collector collector;
  collector.OnInfo(OneAxis());
  constexpr int kSamples = 1000, kEvery = 10;
  for (int i = 0; i < kSamples; ++i) {
    Sample(i * kSample_s, &collector);
    const int reading = i - ahead;
    if (reading >= 0 && reading % kEvery == 0) Read(reading * kSample_s, &collector);
  }
  return collector.Take();
}

class SamplesAhead : public ::testing::TestWithParam<int> {};

TEST_P(SamplesAhead, TheMeanOfANodeIsOfTheTimeSinceTheNodeBefore) {
  const Recording recording = Record(GetParam());
  const std::vector<calibration::Node>& nodes = recording.columns.nodes;
  ASSERT_GT(nodes.size(), 80u);
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    // Of samples evenly in (before, node]: half a sample after the middle.
    const double middle_s = 0.5 * (nodes[k - 1].at.t_s + nodes[k].at.t_s + kSample_s);
    EXPECT_NEAR(nodes[k].temperature_degC, middle_s, 1e-9);
    EXPECT_NEAR(recording.columns.covariates[k], middle_s, 1e-9);
  }
}

INSTANTIATE_TEST_SUITE_P(OfReadings, SamplesAhead, ::testing::Values(0, 1, 7, 30, 60));

// Whatever is asked for when: every sample is in one mean, the first whose time is not before it.
TEST(BesideGyro, CountsEverySampleOnce) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_int_distribution<int> few(1, 40);
    BesideGyro beside;
    beside.Start(1);
    std::vector<double> covariates;
    int sent = 0;
    for (int upto = 0; upto < 3000;) {
      const int last = upto;
      upto += few(random);
      for (; sent <= upto + 200; ++sent) {
        GyroSample sample;
        sample.t_s = sent;
        sample.temperature_degC = sent;
        beside.Add(sample);
        const double value = sent;
        beside.AddCovariates(sent, std::span(&value, 1));
      }
      const double mean = last == 0 ? 0.5 * upto : 0.5 * (last + 1 + upto);
      EXPECT_DOUBLE_EQ(beside.TakeUpTo(upto, &covariates).temperature_degC, mean);
      EXPECT_DOUBLE_EQ(covariates.at(0), mean);
    }
  }
}

TEST(BesideGyro, WhatIsNoNumberDoesNotCountAndNothingIsNoNumber) {
  BesideGyro beside;
  beside.Start(1);
  std::vector<double> covariates;
  const double values[] = {2.0, kMissing, 4.0};
  for (int i = 0; i < 3; ++i) beside.AddCovariates(i, std::span(values + i, 1));
  EXPECT_TRUE(std::isnan(beside.TakeUpTo(2.0, &covariates).temperature_degC));
  EXPECT_DOUBLE_EQ(covariates.at(0), 3.0);
  beside.TakeUpTo(3.0, &covariates);
  EXPECT_TRUE(std::isnan(covariates.at(0)));
}

// 512 rows wait; what came before them counts although its time is later.
TEST(BesideGyro, TheOldestOfTooManyCountForTheNextMean) {
  BesideGyro beside;
  beside.Start(1);
  std::vector<double> covariates;
  constexpr int kMany = 5000;
  for (int i = 0; i < kMany; ++i) {
    const double value = i;
    beside.AddCovariates(1e9 + i, std::span(&value, 1));
  }
  beside.TakeUpTo(0.0, &covariates);
  EXPECT_DOUBLE_EQ(covariates.at(0), 0.5 * (kMany - 512 - 1));
  beside.TakeUpTo(2e9, &covariates);
  EXPECT_DOUBLE_EQ(covariates.at(0), 0.5 * (kMany - 512 + kMany - 1));
}

// One field of the accelerometer that is empty is one sample less, and no more.
TEST(BesideGyro, FeelsVibrationBesideAFieldThatIsEmpty) {
  BesideGyro beside;
  beside.Start(0);
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 0.02);
  for (int i = 0; i < 10'000; ++i) {
    GyroSample sample;
    sample.t_s = 0.001 * i;
    sample.accel_g = {noise(random), noise(random), 1.0 + noise(random)};
    if (i % 7 == 0) sample.accel_g[1] = kMissing;
    beside.Add(sample);
    std::vector<double> none;
    if (i % 100 != 99) continue;
    EXPECT_NEAR(beside.TakeUpTo(sample.t_s, &none).vibration_g2, 3 * 0.02 * 0.02, 5e-4) << i;
  }
}

}  // namespace
}  // namespace gyrobench::testing
