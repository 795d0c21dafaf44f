#include "base/tick_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace gyrobench {
namespace {

std::vector<TickPair> Line(double ratio, double host0_s, double jitter_s, int count,
                           unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, jitter_s);
  std::vector<TickPair> pairs;
  for (int i = 0; i < count; ++i) {
    const double tick = 1000.0 + 0.07 * i;
    pairs.push_back({tick, host0_s + ratio * tick + (jitter_s > 0 ? normal(random) : 0.0)});
  }
  return pairs;
}

TEST(TickFit, FindsAnExactLine) {
  TickFit fit;
  for (const TickPair& pair : Line(1.0025, 1.7e9, 0.0, 500, 0)) fit.Add(pair);
  EXPECT_NEAR(fit.ratio(), 1.0025, 1e-9);
  EXPECT_NEAR(fit.HostTime(2000.0), 1.7e9 + 1.0025 * 2000.0, 1e-6);
  EXPECT_LT(fit.residual_rms_s(), 1e-6);
}

TEST(TickFit, SaysWhatItDoesNotKnow) {
  TickFit fit;
  EXPECT_TRUE(std::isnan(fit.HostTime(1.0)));
  fit.Add({10.0, 20.0});
  EXPECT_DOUBLE_EQ(fit.HostTime(11.0), 21.0);
  EXPECT_TRUE(std::isnan(fit.ratio()));
  fit.Add({11.0, 21.0});
  EXPECT_TRUE(std::isnan(fit.ratio_std_error()));
}

// Over 400 seeds the error divided by its standard error has unit variance: 400 draws put the mean
// square within 1 +- 0.25 in all but 5 of 10 000 cases.
TEST(TickFit, TheStandardErrorIsHonest) {
  double sum = 0.0;
  constexpr int kSeeds = 400;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    TickFit fit;
    for (const TickPair& pair : Line(0.9975, 5.0, 3e-4, 200, seed)) fit.Add(pair);
    const double z = (fit.ratio() - 0.9975) / fit.ratio_std_error();
    sum += z * z;
  }
  EXPECT_NEAR(sum / kSeeds, 1.0, 0.25);
}

TEST(TickFit, WithForgettingItFollowsAClockThatDrifts) {
  TickFit forgetting(30.0);
  TickFit rigid;
  double host = 0.0;
  double tick = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double ratio = 1.0 + 1e-7 * tick;
    tick += 0.07;
    host += 0.07 * ratio;
    forgetting.Add({tick, host});
    rigid.Add({tick, host});
  }
  EXPECT_NEAR(forgetting.HostTime(tick), host, 2e-4);
  EXPECT_GT(std::abs(rigid.HostTime(tick) - host), 1e-2);
  EXPECT_TRUE(std::isnan(forgetting.ratio_std_error()));
}

// As without the start in between, within what two lines know less than one.
TEST(TickFit, AUnitThatBeginsAnewIsOnAnotherLineOfTheSameRatio) {
  double sum = 0.0;
  constexpr int kSeeds = 400;
  for (unsigned seed = 0; seed < kSeeds; ++seed) {
    TickFit fit;
    for (const TickPair& pair : Line(0.9975, 5.0, 3e-4, 100, seed)) fit.Add(pair);
    for (TickPair pair : Line(0.9975, 5.0, 3e-4, 100, kSeeds + seed)) {
      pair.tick_s -= 1000.0;  // the tick goes back by itself, the host's clock does not
      pair.host_s += 20.0;
      fit.Add(pair);
    }
    EXPECT_NEAR(fit.residual_rms_s(), 3e-4, 1e-4);
    EXPECT_NEAR(fit.HostTime(7.0), 5.0 + 0.9975 * 1007.0 + 20.0, 1e-3);
    const double z = (fit.ratio() - 0.9975) / fit.ratio_std_error();
    sum += z * z;
  }
  EXPECT_NEAR(sum / kSeeds, 1.0, 0.25);
}

TEST(TickFit, DoesNotDependOnWhereTimeBegins) {
  TickFit near;
  TickFit far;
  for (const TickPair& pair : Line(1.001, 0.0, 1e-4, 300, 7)) {
    near.Add(pair);
    far.Add({pair.tick_s + 1e6, pair.host_s + 1e9});
  }
  EXPECT_NEAR(near.ratio(), far.ratio(), 1e-6);
}

}  // namespace
}  // namespace gyrobench
