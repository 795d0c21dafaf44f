#include "stand/motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace gyrobench::stand {
namespace {

const Segment& SegmentAt(const Plan& plan, double t_s) {
  const Segment* found = &plan.segments().front();
  for (const Segment& segment : plan.segments()) {
    if (segment.t0_s <= t_s) found = &segment;
  }
  return *found;
}

struct Case {
  Plan plan;
  Ramp ramp;
  double target;
};

Case RandomCase(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const MoveCommand command{.target = static_cast<std::int64_t>(uniform(-40000, 40000)),
                            .rpm = std::floor(uniform(1, 600)),
                            .ramp_up_ms = uniform(20, 2000),
                            .ramp_down_ms = uniform(20, 2000)};
  const Ramp ramp = RampOf(command, 10000, uniform(-1e-3, 1e-3));
  const double v = uniform(0, 1) < 0.5 ? 0.0 : uniform(-ramp.speed, ramp.speed);
  return {PlanMove(10.0, std::floor(uniform(-9000, 9000)), v, command.target, ramp), ramp,
          static_cast<double>(command.target)};
}

TEST(Motion, EveryMoveEndsAtRestOnTheWholePulseThatWasCommanded) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 500; ++i) {
    const Case move = RandomCase(random);
    EXPECT_TRUE(move.plan.back().Rests());
    EXPECT_EQ(move.plan.back().x0, move.target);
  }
}

TEST(Motion, PositionAndRateNeverJump) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 500; ++i) {
    const Case move = RandomCase(random);
    const auto segments = move.plan.segments();
    for (std::size_t k = 1; k < segments.size(); ++k) {
      const double t = segments[k].t0_s;
      EXPECT_GE(t, segments[k - 1].t0_s);
      EXPECT_NEAR(segments[k - 1].Position(t), segments[k].Position(t), 1e-5);
      EXPECT_NEAR(segments[k - 1].Rate(t), segments[k].Rate(t), 1e-4 * move.ramp.speed);
    }
  }
}

TEST(Motion, RateAndAccelerationStayWithinTheCommand) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 300; ++i) {
    const Case move = RandomCase(random);
    const double most = std::max(move.ramp.up, move.ramp.down);
    for (const Segment& segment : move.plan.segments())
      EXPECT_LE(std::abs(segment.a), most * (1 + 1e-9));
    for (double t = 10.0; t < move.plan.back().t0_s; t += 0.01) {
      EXPECT_LE(std::abs(SegmentAt(move.plan, t).Rate(t)), move.ramp.speed * (1 + 1e-9));
    }
  }
}

// Without a cruise the peak is where the two ramps meet.
TEST(Motion, AShortMoveTakesTheTimeOfTwoRamps) {
  const Ramp ramp{.speed = 1e9, .up = 400.0, .down = 100.0};
  const Plan plan = PlanMove(0.0, 0.0, 0.0, 1000, ramp);
  const double expected = std::sqrt(2.0 * 1000.0 * (1 / 400.0 + 1 / 100.0));
  EXPECT_NEAR(plan.back().t0_s, expected, 1e-9);
}

TEST(Motion, AQuickStopEndsOnAWholePulseWithinOnePulseOfItsRamp) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> speed(-50000, 50000);
  for (int i = 0; i < 300; ++i) {
    const double v = speed(random);
    const double x = speed(random);
    const Plan plan = PlanStop(1.0, x, v, 1e5);
    const double end = plan.back().x0;
    EXPECT_EQ(end, std::round(end));
    const double way = v * std::abs(v) / 2e5;
    EXPECT_GE((end - x - way) * (v > 0 ? 1 : -1), -1e-9);
    EXPECT_LE(std::abs(end - x - way), 1.0 + 1e-9);
  }
}

}  // namespace
}  // namespace gyrobench::stand
