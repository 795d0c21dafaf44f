#include "stand/low_pass.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

namespace gyrobench::stand {
namespace {

struct DataSheet {
  double bandwidth_hz, delay_s;
};
constexpr DataSheet kFilters[] = {{256, 0.00098}, {188, 0.0019}, {98, 0.0028}, {42, 0.0048},
                                  {20, 0.0083},   {10, 0.0134},  {5, 0.0186}};
constexpr double kStep_s = 1e-3;

class LowPassTest : public testing::TestWithParam<DataSheet> {
 protected:
  LowPassTest() { filter_.Configure(GetParam().bandwidth_hz, GetParam().delay_s, kStep_s); }
  LowPass filter_;
};

// A ramp comes out as the same ramp, late by the delay.
TEST_P(LowPassTest, DelaysARampByTheDataSheetsGroupDelay) {
  const double slope = 100.0;
  double t = 0.0;
  for (int i = 0; i < 2000; ++i) {
    t += kStep_s;
    const double mean = slope * (t - filter_.pure_delay_s() - 0.5 * kStep_s);
    filter_.Step({mean, mean, mean});
  }
  EXPECT_NEAR(t - filter_.value()[0] / slope, GetParam().delay_s, 1e-9);
}

TEST_P(LowPassTest, KeepsTheIntegral) {
  double in = 0.0;
  double out = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double u = i < 100 ? std::sin(0.1 * i) + 1.0 : 0.0;
    filter_.Step({u, 0, 0});
    in += u;
    out += filter_.value()[0];
  }
  EXPECT_NEAR(out, in, 1e-9 * in);
}

TEST_P(LowPassTest, ManyStepsInOneAreTheSameAsOneAfterTheOther) {
  LowPass other = filter_;
  for (int i = 0; i < 5; ++i) filter_.Step({1, 2, 3});
  other.Step({1, 2, 3}, other.Fraction(5));
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(filter_.value()[i], other.value()[i], 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Settings, LowPassTest, testing::ValuesIn(kFilters));

// Where the data sheet's delay leaves room for a first-order lag (42 Hz), the gain there is
// 1/sqrt(2).
TEST(LowPass, ItsBandwidthIsTheDataSheets) {
  LowPass filter;
  filter.Configure(42, 0.0048, kStep_s);
  std::complex<double> sum = 0;
  const double w = 2 * std::numbers::pi * 42;
  for (int i = 0; i < 20000; ++i) {
    filter.Step({std::sin(w * i * kStep_s), 0, 0});
    if (i >= 10000) sum += filter.value()[0] * std::polar(1.0, -w * i * kStep_s) * 2e-4;
  }
  EXPECT_NEAR(std::abs(sum), 1 / std::sqrt(2.0), 0.02);
}

TEST(LowPass, ALagAloneDelaysARampByItsTimeConstant) {
  LowPass lag;
  lag.ConfigureLag(0.02, kStep_s);
  for (int i = 0; i < 5000; ++i) lag.Step({1.0 * i, 0, 0});
  EXPECT_NEAR((4999 - lag.value()[0]) * kStep_s, 0.02, 1e-9);
  EXPECT_EQ(lag.pure_delay_s(), 0.0);
}

}  // namespace
}  // namespace gyrobench::stand
