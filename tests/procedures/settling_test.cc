// Temperatures that go as end - cold exp(-t / tau), with the noise of a thermometer.
#include "procedures/engine/settling.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace gyrobench::procedures {
namespace {

constexpr double kPeriod_s = 1.0;

SoakCommand Soak(double drift_degC = 0.1, double window_s = 120.0, double max_s = 3600.0) {
  SoakCommand command;
  command.drift_degC = drift_degC;
  command.window_s = window_s;
  command.max_s = max_s;
  return command;
}

// Time at which it settled, max_s where it did not. `at` is asked each second.
double SettledAfter_s(const SoakCommand& command, const std::function<double(double t_s)>& degC,
                      const std::function<void(double t_s, const Settling&)>& at = {}) {
  Settling settling(command, 0.0);
  for (double t_s = kPeriod_s; t_s < command.max_s; t_s += kPeriod_s) {
    settling.Add(t_s, degC(t_s));
    if (at) at(t_s, settling);
    if (settling.settled()) return t_s;
  }
  return command.max_s;
}

std::function<double(double)> Warming(double cold_degC, double tau_s, double noise_degC) {
  return [=, random = std::mt19937_64(7),
          normal = std::normal_distribution<double>()](double t_s) mutable {
    return 38.0 - cold_degC * std::exp(-t_s / tau_s) + noise_degC * normal(random);
  };
}

// The peaks of this noise alone are 0.25 degC apart: it must not keep a soak from its end.
TEST(Settling, EndsWhenTheDriftIsBelowTheOneAskedForWhateverTheThermometersNoise) {
  for (const double cold_degC : {10.0, 40.0}) {
    const double expected_s = ExpectedSoak_s(Soak(), 0.0, cold_degC, 250.0);
    for (const double noise_degC : {0.0, 0.05}) {
      const double settled_s = SettledAfter_s(Soak(), Warming(cold_degC, 250.0, noise_degC));
      EXPECT_NEAR(settled_s, expected_s, 0.1 * expected_s) << cold_degC << ' ' << noise_degC;
    }
  }
}

TEST(Settling, ASwingThatEndsWhereItBeganIsNotSettled) {
  const auto swing = [](double t_s) { return 0.5 * std::cos(2.0 * std::acos(-1.0) * t_s / 120.0); };
  EXPECT_EQ(SettledAfter_s(Soak(), swing), 3600.0);
}

TEST(Settling, ForetellsItsEndFromTheDecayThatItSees) {
  for (const double tau_s : {120.0, 250.0, 500.0}) {
    const double end_s = SettledAfter_s(Soak(), Warming(40.0, tau_s, 0.02));
    ASSERT_LT(end_s, 3600.0);
    SettledAfter_s(Soak(), Warming(40.0, tau_s, 0.02), [&](double t_s, const Settling& settling) {
      if (t_s < 300.0 || t_s > 0.8 * end_s) return;
      ASSERT_NEAR(t_s + settling.remaining_s(), end_s, 0.2 * end_s) << tau_s << ' ' << t_s;
    });
  }
}

TEST(Settling, TheTimeLeftIsNeverBeyondTheEndOfTheWaitNorBeforeItsLeast) {
  SoakCommand command = Soak(0.1, 60.0, 900.0);
  command.min_s = 600.0;
  const double end_s =
      SettledAfter_s(command, Warming(2.0, 50.0, 0.0), [&](double t_s, const Settling& settling) {
        ASSERT_LE(t_s + settling.remaining_s(), 900.0 + 1e-9);
        ASSERT_GE(t_s + settling.remaining_s(), 600.0 - 1e-9);
      });
  EXPECT_EQ(end_s, 600.0);
}

TEST(Settling, NothingSettlesWithoutATemperature) {
  EXPECT_EQ(SettledAfter_s(Soak(), [](double) { return std::numeric_limits<double>::quiet_NaN(); }),
            3600.0);
}

}  // namespace
}  // namespace gyrobench::procedures
