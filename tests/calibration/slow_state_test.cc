// The state for the correction, where columns are missing for a time.
#include "calibration/state/slow_state.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace gyrobench::calibration {
namespace {

struct Seen {
  double t_s, temperature_degC, rate_degC_s, covariate;
};

// Samples at 20 Hz; asks for every sample as soon as it is known.
std::vector<Seen> Watch(double duration_s, const std::function<double(double)>& temperature_degC,
                        const std::function<double(double)>& covariate, double* longest_wait_s) {
  SlowState state(1);
  std::vector<double> times;
  std::vector<Seen> out;
  const auto take = [&] {
    while (out.size() < times.size() && state.Knows(times[out.size()])) {
      SensorState point;
      state.At(times[out.size()], &point);
      out.push_back({times[out.size()], point.temperature_degC, point.temperature_rate_degC_s,
                     point.covariates[0]});
    }
  };
  *longest_wait_s = 0.0;
  for (int i = 0; i < static_cast<int>(20.0 * duration_s); ++i) {
    GyroSample sample;
    sample.t_s = 0.05 * i;
    sample.temperature_degC = temperature_degC(sample.t_s);
    times.push_back(sample.t_s);
    state.Add(sample, std::array<double, 1>{covariate(sample.t_s)});
    take();
    if (out.size() < times.size())
      *longest_wait_s = std::max(*longest_wait_s, sample.t_s - times[out.size()]);
  }
  state.End();
  take();
  return out;
}

std::function<double(double)> Gap(double begin_s, double end_s) {
  return [=](double t_s) { return t_s > begin_s && t_s < end_s ? kMissing : 20.0 + 0.05 * t_s; };
}

TEST(SlowState, BridgesAShortGapByAStraightLine) {
  double wait_s = 0.0;
  const std::vector<Seen> seen = Watch(200.0, Gap(50.0, 100.0), Gap(50.0, 90.0), &wait_s);
  ASSERT_EQ(seen.size(), 4000u);
  for (const Seen& at : seen) {
    EXPECT_NEAR(at.temperature_degC, 20.0 + 0.05 * at.t_s, 0.01) << at.t_s;
    EXPECT_NEAR(at.rate_degC_s, 0.05, 1e-3) << at.t_s;
    EXPECT_NEAR(at.covariate, 20.0 + 0.05 * at.t_s, 0.01) << at.t_s;
  }
}

TEST(SlowState, SaysThatItDoesNotKnowInALongGap) {
  double wait_s = 0.0;
  const std::vector<Seen> seen = Watch(300.0, Gap(50.0, 150.0), Gap(70.0, 140.0), &wait_s);
  ASSERT_EQ(seen.size(), 6000u);
  for (const Seen& at : seen) {
    if (at.t_s > 52.0 && at.t_s < 148.0) {
      EXPECT_TRUE(std::isnan(at.temperature_degC) && std::isnan(at.rate_degC_s)) << at.t_s;
    } else if (at.t_s < 50.0 || at.t_s > 150.0) {
      EXPECT_NEAR(at.temperature_degC, 20.0 + 0.05 * at.t_s, 0.01) << at.t_s;
      EXPECT_NEAR(at.rate_degC_s, 0.05, 1e-3) << at.t_s;
    }
    if (at.t_s > 71.2 && at.t_s < 138.8) {
      EXPECT_TRUE(std::isnan(at.covariate)) << at.t_s;
    } else if (at.t_s < 70.9 || at.t_s > 139.1) {
      EXPECT_TRUE(std::isfinite(at.covariate)) << at.t_s;
    }
  }
  EXPECT_LT(wait_s, 66.0) << "a gap is waited for no longer than it could be bridged";
}

TEST(SlowState, DoesNotWaitForAColumnThatNeverComes) {
  double wait_s = 0.0;
  const auto never = [](double) { return kMissing; };
  const std::vector<Seen> seen = Watch(100.0, never, never, &wait_s);
  ASSERT_EQ(seen.size(), 2000u);
  EXPECT_LT(wait_s, 6.0);
  for (const Seen& at : seen) EXPECT_TRUE(std::isnan(at.temperature_degC));
}

}  // namespace
}  // namespace gyrobench::calibration
