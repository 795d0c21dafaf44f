#include <gtest/gtest.h>

#include <cmath>

#include "drivers/gyro_unit.h"

namespace gyrobench::drivers {
namespace {

constexpr double kWrap_s = 4294967296.0 / 250'000.0;  // 4.8 h
constexpr double kRate_hz = 200.0;

// What a unit that was started so long ago tells, whose sensor's clock is off by `rate_error`.
std::optional<double> Told(double up_s, double rate_error = 0.0) {
  const auto samples = static_cast<std::int64_t>(up_s * kRate_hz * (1.0 + rate_error));
  return SecondsSinceBoot(std::fmod(up_s, kWrap_s), kWrap_s, samples, kRate_hz);
}

TEST(SecondsSinceBoot, IsTheTicksWithAsManyWrapsAsTheSampleNumberTells) {
  for (const double rate_error : {-0.02, 0.0, 0.02}) {
    for (const double up_s : {0.0, 0.5, 3600.0, kWrap_s - 1.0, kWrap_s + 1.0, 100'000.0, 250'000.0})
      EXPECT_NEAR(Told(up_s, rate_error).value_or(-1.0), up_s, 1e-6) << up_s << " " << rate_error;
  }
}

TEST(SecondsSinceBoot, IsNotKnownWhereTheUnitSampledAtAnotherRate) {
  EXPECT_FALSE(SecondsSinceBoot(3600.0, kWrap_s, 3600 * 1000, kRate_hz));
  EXPECT_FALSE(SecondsSinceBoot(3600.0, kWrap_s, 3600 * 100, kRate_hz));
  EXPECT_FALSE(SecondsSinceBoot(3600.0, kWrap_s, 3600 * 200, 0.0));
}

TEST(SecondsSinceBoot, IsNotKnownOnceAWrapMoreFitsAsWell) { EXPECT_FALSE(Told(400'000.0)); }

}  // namespace
}  // namespace gyrobench::drivers
