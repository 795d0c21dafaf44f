#include "commission/delay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace gyrobench::commission {
namespace {

// A swing out and to rest: rate and angle in closed form.
double Angle_deg(double t_s) {
  const double t = std::clamp(t_s, 0.0, 1.0);
  return 4.0 * (t - std::sin(2.0 * std::numbers::pi * t) / (2.0 * std::numbers::pi));
}
double Rate_deg_s(double t_s) {
  return t_s <= 0.0 || t_s >= 1.0 ? 0.0 : 4.0 * (1.0 - std::cos(2.0 * std::numbers::pi * t_s));
}

// `scale` counts a degree; the second encoder stands still but for a count now and then.
DelaySeen AfterOneMove(double delay_s, double scale) {
  DelaySeen delays;
  delays.Begin(2);
  for (int k = 0; k < 60; ++k) {
    const double t_s = 0.02 * k;
    const auto counts =
        static_cast<std::int32_t>(std::lround(1e5 + scale * Angle_deg(t_s - delay_s)));
    const auto value = static_cast<std::uint32_t>(counts);
    delays.Add(0, {FromSeconds(t_s),
                   {static_cast<std::uint16_t>(value >> 16), static_cast<std::uint16_t>(value)}});
    delays.Add(1, {FromSeconds(t_s), {0, static_cast<std::uint16_t>(700 + k % 2)}});
  }
  std::vector<Devices::Rate> rates;
  const Vector3 rest_deg_s = {0.5, -2.0, 1.0};
  for (int i = -20; i < 260; ++i) {
    const double t_s = 0.005 * i, rate = Rate_deg_s(t_s);
    rates.push_back({FromSeconds(t_s), {0.5 + 0.6 * rate, -2.0, 1.0 - 0.8 * rate}});
  }
  delays.End(rates, rest_deg_s);
  return delays;
}

TEST(Delay, IsFoundWhateverTheScaleAndTheSenseOfTheCounts) {
  for (const double delay_s : {0.0, 0.004, 0.02, 0.05}) {
    for (const double scale : {364.0, -364.0, 2000.0}) {
      const auto found = AfterOneMove(delay_s, scale).Found();
      ASSERT_TRUE(found[0].has_value()) << delay_s << " s, " << scale;
      // To first order in the delay.
      EXPECT_NEAR(found[0]->value_s, delay_s, 3e-4 + 0.05 * delay_s) << scale;
      EXPECT_GT(found[0]->std_error_s, 0.0);
    }
  }
}

TEST(Delay, OfAnEncoderThatStandsStillNothingIsSaid) {
  EXPECT_FALSE(AfterOneMove(0.01, 364.0).Found()[1].has_value());
}

}  // namespace
}  // namespace gyrobench::commission
