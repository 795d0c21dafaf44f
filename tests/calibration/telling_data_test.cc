// What is said of data that are whole and yet cannot tell: a temperature that goes one way alone, a
// reference that nobody read, a gyro that is sampled seldom for its motion.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "calibration/signal/intake.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using ::testing::Contains;
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
        std::function<double(double)>([](double t) { return 25.0 + 0.003 * t; })})
    EXPECT_THAT(RemarksAt(temperature), Not(Contains(HasSubstr("only rose"))));
}

TEST(AReference, ThatNoRowFillsIsSaidToHaveNoValue) {
  Story story;
  story.spoil_angle = [](AngleSample*) { return false; };
  EXPECT_THAT(calibration::IntakeRemarks(story.Collect()),
              Contains(HasSubstr("no row has a value in them")));
  EXPECT_THAT(calibration::IntakeRemarks(Story().Collect()),
              Not(Contains(HasSubstr("no row has a value in them"))));
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

TEST(AGyro, SampledSeldomForItsMotionIsSaidToBe) {
  const auto remarks = [](double gyro_hz, bool straight) {
    Story story;
    story.UseTurningChannelAlone();
    story.gyro_hz = gyro_hz;
    story.reference_hz = 10.0;
    story.white_deg_s = 0.004 * std::sqrt(gyro_hz);
    if (straight) {
      story.rate_deg_s = RampRate;
      story.angle_deg = RampAngle;
    }
    return TraceOf(story.Collect()).remarks;
  };
  EXPECT_THAT(remarks(20.0, true), Contains(HasSubstr("the gyro is sampled every 0.05 s")));
  EXPECT_THAT(remarks(100.0, true), Not(Contains(HasSubstr("the gyro is sampled every"))));
  // Of ramps without a corner nothing is left at their ends.
  EXPECT_THAT(remarks(20.0, false), Not(Contains(HasSubstr("the gyro is sampled every"))));
}

}  // namespace
}  // namespace gyrobench::testing
