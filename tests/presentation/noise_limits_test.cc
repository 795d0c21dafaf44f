#include "presentation/noise_limits.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrobench::presentation {
namespace {

TEST(NoiseLimits, AZeroIsNeverAFigureAndWhatIsAbsentIsNotHidden) {
  const NoiseFigures zeros = JudgeNoise({0.0, 0.0, 0.0}, 600.0);
  EXPECT_TRUE(zeros.angle_random_walk.hidden());
  EXPECT_TRUE(zeros.bias_random_walk.hidden());
  EXPECT_TRUE(zeros.reference.hidden());
  const NoiseFigures absent = JudgeNoise({}, kMissing);
  EXPECT_FALSE(absent.angle_random_walk.hidden());
  EXPECT_FALSE(absent.bias_random_walk.hidden());
  EXPECT_FALSE(absent.reference.hidden());
}

TEST(NoiseLimits, TypicalFiguresOfAnMpu6050AreSeenInTenMinutes) {
  const NoiseFigures figures = JudgeNoise({0.0035, 1e-4, 0.005}, 600.0);
  EXPECT_FALSE(figures.angle_random_walk.hidden());
  EXPECT_FALSE(figures.bias_random_walk.hidden());
  EXPECT_FALSE(figures.reference.hidden());
}

// Ten times the time shows what is smaller; ten times the noise that hides it, what is larger.
TEST(NoiseLimits, FallWithTimeAndGrowWithTheNoiseThatHides) {
  const NoiseFigures base = JudgeNoise({0.005, 1e-4, 0.01}, 600.0);
  const NoiseFigures longer = JudgeNoise({0.005, 1e-4, 0.01}, 6000.0);
  const NoiseFigures noisier = JudgeNoise({0.05, 1e-4, 0.1}, 600.0);
  EXPECT_NEAR(longer.bias_random_walk.limit, base.bias_random_walk.limit / 10.0, 1e-12);
  EXPECT_NEAR(noisier.bias_random_walk.limit, base.bias_random_walk.limit * 10.0, 1e-12);
  EXPECT_NEAR(noisier.angle_random_walk.limit, base.angle_random_walk.limit * 10.0, 1e-12);
  EXPECT_LT(longer.reference.limit, base.reference.limit);
}

// The mean rate over all of the time is known to N / sqrt(T), a walk that moves it by as much is
// as large as K = N / T.
TEST(NoiseLimits, OfABiasWalkIsWhatMovesTheMeanRateByItsError) {
  const double n = 0.005, t_s = 900.0;
  const double limit = JudgeNoise({n, 1e-9, kMissing}, t_s).bias_random_walk.limit;
  EXPECT_NEAR(limit * std::sqrt(t_s), n / std::sqrt(t_s), 1e-12);
}

}  // namespace
}  // namespace gyrobench::presentation
