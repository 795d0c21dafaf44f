#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "base/measurement.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

// The size in words, as a share.
double ShareIn(const std::string& text) {
  const double number = std::atof(text.c_str());
  return number * (text.find(" % ") != std::string::npos ? 1e-2 : 1e-6);
}

TEST(ScaleAtRate, GivesTheShareOfTheRateThatTheTermMakes) {
  for (const double rate : {5.0, 40.0, 250.0}) {
    for (const double c : {-3e-6, 1e-9, 2e-5}) {
      const double odd = c * rate * rate / rate, cubic = c * rate * rate * rate / rate;
      EXPECT_NEAR(ShareIn(ScaleAtRate(c, "1/(deg/s)", rate)), odd, 0.06 * std::fabs(odd));
      EXPECT_NEAR(ShareIn(ScaleAtRate(c, "1/(deg/s)^2", rate)), cubic, 0.06 * std::fabs(cubic));
    }
  }
  EXPECT_EQ(ScaleAtRate(5e-4 / 40.0, "1/(deg/s)", 40.0), "0.05 % at 40 deg/s");
}

TEST(ScaleAtRate, SaysNothingOfOtherUnitsNorWithoutARate) {
  for (const char* unit : {"", "1", "1/g", "deg/s", "1/(deg/s)x", "1/(deg/s)^"})
    EXPECT_EQ(ScaleAtRate(1e-3, unit, 40.0), "") << unit;
  EXPECT_EQ(ScaleAtRate(1e-3, "1/(deg/s)", kMissing), "");
  EXPECT_EQ(ScaleAtRate(1e-3, "1/(deg/s)", 0.0), "");
  EXPECT_EQ(ScaleAtRate(kMissing, "1/(deg/s)", 40.0), "");
}

TEST(LargestRate, IsThatOfTheCurveEitherWay) {
  calibration::ChannelTrace channel;
  EXPECT_TRUE(std::isnan(LargestRate_deg_s(channel)));
  channel.curves.rate_error_by_rate_deg_s.x = {-41.0, kMissing, 12.0, 40.0};
  EXPECT_EQ(LargestRate_deg_s(channel), 41.0);
}

}  // namespace
}  // namespace gyrobench::presentation
