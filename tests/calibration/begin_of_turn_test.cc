// A turn begins before the gyro clearly feels it: how it goes on says when. A play is crossed just
// there; were the first of it left out, or put too early, the play would seem smaller than it is.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "calibration/state/state_history.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {
namespace {

using calibration::MakeStateHistory;
using calibration::StateHistory;

// Since the rest before: how far the table was turned, and by the way that is followed.
struct Begin {
  double turned_deg = 0.0, way_deg = 0.0;  // in the sense of the turn
};

// Of the nodes up to which the table had turned by no more than the gyro's noise hides. `motion`
// rests for a second and more before each turn.
std::vector<Begin> HiddenBegins(const Motion& motion, double walk_deg_sqrt_s, std::uint64_t seed) {
  BenchSensor sensor;
  sensor.m_row = {0.0, 0.0, 1.0};
  sensor.angle_random_walk_deg_sqrt_s = walk_deg_sqrt_s;
  const double hidden_deg = 4.0 * walk_deg_sqrt_s * std::sqrt(0.1);
  const StateHistory history =
      MakeStateHistory(SyntheticBench(motion, sensor).Measure({}, seed), {1.0, 1.0, 1.0}, true, {});
  const auto turned_at = [&](double t_s) { return motion.At(t_s).angle_deg[kInnerAxis]; };
  const auto way_deg = [&](std::size_t node) {
    return history.gyro_turns[node].table_way_deg.back()[kInnerAxis];
  };
  std::vector<Begin> found;
  for (std::size_t k = 10; k < history.nodes.size(); ++k) {
    const double t_s = history.gyro_turns[k].t_s + history.gyro_turns[k].way_end_s;
    const double from_deg = turned_at(t_s - 1.0), turned_deg = turned_at(t_s) - from_deg;
    const bool rested = turned_at(t_s - 0.5) == from_deg;
    if (!rested || turned_deg == 0.0 || std::fabs(turned_deg) > hidden_deg) continue;
    found.push_back(
        {std::fabs(turned_deg), std::copysign(1.0, turned_deg) * (way_deg(k) - way_deg(k - 10))});
  }
  return found;
}

struct Errors {
  int begins = 0;
  double turned_deg = 0.0, way_deg = 0.0, rms_deg = 0.0, largest_deg = 0.0;  // the first: sums
};

// Of turns that begin at any part of a node.
Errors ErrorsOfTurns(double rate_deg_s, double ramp_s, double walk_deg_sqrt_s) {
  Errors out;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Motion motion(ramp_s);
    for (int i = 0; i < 15; ++i)
      motion.Rest(5.0 + 0.017 * i).ThereAndBack(kInnerAxis, 60.0, rate_deg_s);
    motion.Rest(5.0);
    for (const Begin& begin : HiddenBegins(motion, walk_deg_sqrt_s, seed)) {
      const double error_deg = begin.way_deg - begin.turned_deg;
      ++out.begins;
      out.turned_deg += begin.turned_deg;
      out.way_deg += begin.way_deg;
      out.rms_deg += error_deg * error_deg;
      out.largest_deg = std::fmax(out.largest_deg, std::fabs(error_deg));
    }
  }
  out.rms_deg = std::sqrt(out.rms_deg / std::fmax(1.0, out.begins));
  return out;
}

TEST(TurnThatBeginsSoftly, HasWhatTheGyrosNoiseHides) {
  constexpr double kWalk_deg_sqrt_s = 0.01;
  const Errors errors = ErrorsOfTurns(60.0, 0.5, kWalk_deg_sqrt_s);
  ASSERT_GT(errors.begins, 20);
  EXPECT_NEAR(errors.way_deg, errors.turned_deg, 0.35 * errors.turned_deg);
  EXPECT_LT(errors.rms_deg, kWalk_deg_sqrt_s * std::sqrt(0.1));
}

// It is soon at its full rate, and goes on evenly: read as one whose rate grows all the while, it
// would have begun a good part of a node earlier.
TEST(TurnThatBeginsSteeply, DoesNotBeginBeforeItDoes) {
  constexpr double kWalk_deg_sqrt_s = 0.002;
  const double noise_deg = kWalk_deg_sqrt_s * std::sqrt(0.1);
  for (const double ramp_s : {0.05, 0.1}) {
    for (const double rate_deg_s : {10.0, 60.0}) {
      const Errors errors = ErrorsOfTurns(rate_deg_s, ramp_s, kWalk_deg_sqrt_s);
      ASSERT_GT(errors.begins, 5);
      EXPECT_LT(errors.largest_deg, 6.0 * noise_deg)
          << rate_deg_s << " deg/s after " << ramp_s << " s";
    }
  }
}

// The readings alone say that it turns: nothing is felt that could say when it began, and no play
// is crossed the other way first.
TEST(TurnThatIsHardlyFelt, NeverBeginsBackwards) {
  constexpr double kNoisy_deg_sqrt_s = 0.1;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Motion motion;
    for (int i = 0; i < 8; ++i) motion.Rest(5.0 + 0.017 * i).Turn(kInnerAxis, 6.0, 1.0);
    for (const Begin& begin : HiddenBegins(motion.Rest(5.0), kNoisy_deg_sqrt_s, seed))
      EXPECT_GE(begin.way_deg, -1e-9) << "seed " << seed;
  }
}

}  // namespace
}  // namespace gyrobench::testing
