// A temperature that only rises, or only falls: time and temperature say the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace gyrobench::testing
