// What is said of data that are whole and yet cannot tell: a temperature that goes one way alone, a
// reference that nobody read, a gyro that is sampled seldom for its motion.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "calibration/signal/intake.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> RemarksAt(const std::function<double(double)>& temperature_degC) {
  Story story;
  story.temperature_degC = temperature_degC;
  return TraceAll(story.Collect()).remarks;
}

TEST(ATemperature, ThatGoesOneWayAloneIsSaidToTellNoTimeFromTemperature) {
  EXPECT_THAT(RemarksAt([](double t) { return 35.0 - 10.0 * std::exp(-t / 60.0); }),
              Contains(HasSubstr("only rose, from 25.0 to 34.5 degC")));
  EXPECT_THAT(RemarksAt([](double t) { return 40.0 - 0.02 * t; }),
              Contains(HasSubstr("only fell, from 40.0 to 36.4 degC")));
  for (const auto& temperature :
       {std::function<double(double)>([](double t) { return 30.0 + 5.0 * std::sin(t / 20.0); }),
        std::function<double(double)>([](double t) { return 25.0 + 0.003 * t; }),
        // Most of the time it is where it has come to.
        std::function<double(double)>([](double t) { return 35.0 - 10.0 * std::exp(-t / 20.0); })})
    EXPECT_THAT(RemarksAt(temperature), Not(Contains(HasSubstr("the temperature only"))));
}

TEST(AReference, ThatNoRowFillsIsSaidToHaveNoValue) {
  Story story;
  story.spoil_angle = [](AngleSample*) { return false; };
  EXPECT_THAT(calibration::IntakeRemarks(story.Collect()),
              Contains(HasSubstr("has no value at any time")));
  EXPECT_THAT(calibration::IntakeRemarks(Story().Collect()),
              Not(Contains(HasSubstr("has no value at any time"))));
}

TEST(AGyro, WhoseOffsetNoSensorHasIsSaidToHaveAZeroInIt) {
  const auto remarks = [](double counts) {
    Story story;
    story.spoil_gyro = [=](GyroSample* sample) {
      sample->xi[1] += counts;
      return true;
    };
    return calibration::IntakeRemarks(story.Collect());
  };
  EXPECT_THAT(remarks(2048.0 * 16.0), Contains(HasSubstr("gyro y 250 deg/s")));
  EXPECT_THAT(remarks(20.0 * 131.0), Not(Contains(HasSubstr("gyro y"))));
}

TEST(AGyro, ThatFeelsNothingOfTheTurnsDoesNotTurnAtRest) {
  Story story;
  story.scale = {0.0, 0.0, 0.0};
  const calibration::TraceResult result = TraceAll(story.Collect());
  ASSERT_EQ(result.inputs.size(), 1u);
  EXPECT_THAT(result.inputs[0].defects, Not(Contains(Field(&Defect::kind, "turned_at_rest"))));
}

TEST(Stamps, ThatAreAsCoarseAsTheIntervalAreSaidToBe) {
  const auto remarks = [](double gyro_hz, double digit_s) {
    Story story;
    story.gyro_hz = gyro_hz;
    story.spoil_gyro = [=](GyroSample* sample) {
      sample->t_s = digit_s * std::round(sample->t_s / digit_s);
      return true;
    };
    return calibration::IntakeRemarks(story.Collect());
  };
  // A story turns at up to 60 deg/s.
  EXPECT_THAT(remarks(100.02, 0.01),
              Contains(::testing::AllOf(HasSubstr("printed to 0.01 s"), HasSubstr("by 0.6 deg"))));
  EXPECT_THAT(remarks(201.0, 0.01), Contains(HasSubstr("come every 0.004975 s")));
  const auto none = Not(Contains(HasSubstr("stamps are printed")));
  EXPECT_THAT(remarks(100.0, 0.01), none);
  EXPECT_THAT(remarks(50.01, 0.01), none);
  EXPECT_THAT(remarks(100.02, 0.001), none);
}

TEST(AGyro, WhoseStampsAreWholeHasNoOtherRateForAGap) {
  Story story;
  story.gyro_hz = 100.0;
  story.spoil_gyro = [](GyroSample* sample) {
    sample->t_s = 0.01 * std::round(sample->t_s / 0.01);
    return !(sample->t_s > 20.0 && sample->t_s < 23.0);
  };
  EXPECT_THAT(calibration::IntakeRemarks(story.Collect()),
              Not(Contains(HasSubstr("stamps are printed"))));
}

// A rate of straight ramps: 1 s up, 4 s at 40 deg/s, 1 s down, 2 s of rest, and back.
double RampRate(double t_s) {
  const double phase = std::fmod(t_s, 16.0), in_s = std::fmod(phase, 8.0) - 2.0;
  const double size = 40.0 * std::clamp(std::min(in_s, 6.0 - in_s), 0.0, 1.0);
  return phase < 8.0 ? size : -size;
}
double RampAngle(double t_s) {
  const double phase = std::fmod(t_s, 16.0), in_s = std::fmod(phase, 8.0) - 2.0;
  const auto ramp = [](double s) { return 20.0 * std::pow(std::clamp(s, 0.0, 1.0), 2); };
  const double angle = ramp(in_s) + 40.0 * std::clamp(in_s - 1.0, 0.0, 4.0) +
                       (in_s > 5.0 ? 20.0 - ramp(6.0 - in_s) : 0.0);
  return phase < 8.0 ? angle : 200.0 - angle;
}

std::vector<std::string> RemarksOnSampling(double gyro_hz, const std::function<void(Story*)>& move,
                                           std::uint64_t seed) {
  Story story;
  story.UseTurningChannelAlone();
  story.seed = seed;
  story.gyro_hz = gyro_hz;
  story.reference_hz = 10.0;
  story.white_deg_s = 0.002 * std::sqrt(gyro_hz);
  move(&story);
  return TraceOf(story.Collect()).remarks;
}

TEST(AGyro, SampledSeldomForItsMotionIsSaidToBe) {
  const auto ramps = [](Story* story) {
    story->rate_deg_s = RampRate;
    story->angle_deg = RampAngle;
  };
  const auto bends_all_the_time = [](Story* story) {
    constexpr double kOmega = 2.0 * std::numbers::pi * 0.5;
    story->rate_deg_s = [](double t) { return t < 10.0 ? 0.0 : 60.0 * std::sin(kOmega * t); };
    story->angle_deg = [](double t) {
      return t < 10.0 ? 0.0 : 60.0 / kOmega * (1.0 - std::cos(kOmega * t));
    };
  };
  const auto no_corners = [](Story*) {};
  const auto coarse_reference = [](Story* story) { story->reading_deg = 0.02; };
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_THAT(RemarksOnSampling(20.0, ramps, seed),
                Contains(HasSubstr("the gyro is sampled every 0.05 s")));
    EXPECT_THAT(RemarksOnSampling(100.0, ramps, seed),
                Not(Contains(HasSubstr("the gyro is sampled every"))));
    for (const std::function<void(Story*)>& move :
         {std::function<void(Story*)>(bends_all_the_time), std::function<void(Story*)>(no_corners),
          std::function<void(Story*)>(coarse_reference)})
      EXPECT_THAT(RemarksOnSampling(20.0, move, seed),
                  Not(Contains(HasSubstr("the gyro is sampled every"))));
  }
}

}  // namespace
}  // namespace gyrobench::testing
