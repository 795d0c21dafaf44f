// A table that turns so slowly that its encoder stays on one count for many readings, between ramps
// that are as soft: what the readings misread is alike from one to the next.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "calibration/signal/rest_finder.h"
#include "calibration/state/even_turns.h"
#include "calibration/state/state_history.h"
#include "tests/calibration/trace_once.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::AngleSeries;
using calibration::ChannelTrace;
using calibration::Columns;
using calibration::FindEvenTurn;
using calibration::Rest;

// From one rate to the next by the square of a sine, then a stretch at that rate.
struct Stretch {
  double rate_deg_s = 0.0, lasts_s = 0.0;
};
class SoftTurns {
 public:
  SoftTurns(std::span<const Stretch> stretches, double soft_s) : soft_s_(soft_s) {
    double rate = 0.0, angle_deg = 0.0, begin_s = 0.0;
    for (const Stretch& stretch : stretches) {
      pieces_.push_back({begin_s, rate, stretch.rate_deg_s, angle_deg});
      angle_deg +=
          0.5 * (rate + stretch.rate_deg_s) * soft_s + stretch.rate_deg_s * stretch.lasts_s;
      begin_s += soft_s + stretch.lasts_s;
      rate = stretch.rate_deg_s;
    }
    end_s_ = begin_s;
  }
  double end_s() const { return end_s_; }
  double Rate(double t_s) const {
    const Piece& piece = At(t_s);
    const double s = std::min((t_s - piece.begin_s) / soft_s_, 1.0);
    return piece.from + (piece.to - piece.from) * std::pow(std::sin(0.5 * std::numbers::pi * s), 2);
  }
  double Angle(double t_s) const {
    const Piece& piece = At(t_s);
    const double in_s = t_s - piece.begin_s, ramp_s = std::min(in_s, soft_s_);
    const double half = 0.5 * ramp_s - soft_s_ / (2.0 * std::numbers::pi) *
                                           std::sin(std::numbers::pi * ramp_s / soft_s_);
    return piece.angle_deg + piece.from * ramp_s + (piece.to - piece.from) * half +
           piece.to * (in_s - ramp_s);
  }

 private:
  struct Piece {
    double begin_s, from, to, angle_deg;
  };
  const Piece& At(double t_s) const {
    std::size_t i = 0;
    while (i + 1 < pieces_.size() && pieces_[i + 1].begin_s <= t_s) ++i;
    return pieces_[i];
  }
  double soft_s_, end_s_ = 0.0;
  std::vector<Piece> pieces_;
};

const std::vector<Stretch> kSlow = {{0.0, 8.0}, {0.33, 100.0}, {0.0, 6.0}, {-0.143, 120.0},
                                    {0.0, 4.0}, {0.2, 100.0},  {0.0, 6.0}, {-0.31, 90.0},
                                    {0.0, 3.0}, {0.15, 120.0}, {0.0, 7.0}};

struct Read {
  double step_deg, noise_deg;
};

Story TellOf(const SoftTurns& turns, const Read& read, std::uint64_t seed) {
  Story story;
  story.duration_s = turns.end_s();
  story.rate_deg_s = [&turns](double t_s) { return turns.Rate(t_s); };
  story.angle_deg = [&turns](double t_s) { return turns.Angle(t_s); };
  story.white_deg_s = 0.03;
  story.reading_deg = read.noise_deg;
  story.seed = seed;
  if (read.step_deg > 0.0) {
    story.spoil_angle = [step_deg = read.step_deg](AngleSample* reading) {
      reading->angle_deg = step_deg * std::round(reading->angle_deg / step_deg);
      return true;
    };
  }
  return story;
}

constexpr double kTwelveBits_deg = 360.0 / 4096.0, kSixteenBits_deg = 360.0 / 65536.0;

// By the rates of its neighbours alone the rounding passes for a random walk of the bias, and the
// scale factor is what that leaves: 1.7 here.
TEST(ASlowTurnOfACoarseEncoder, HasTheScaleFactorOfTheGyro) {
  const SoftTurns turns(kSlow, 2.5);
  for (const double step_deg : {kTwelveBits_deg, kSixteenBits_deg}) {
    for (const bool of_stand : {true, false}) {
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        Story story = TellOf(turns, {step_deg, 0.0}, seed);
        if (of_stand) {
          story.UseTurningChannelAlone();
        } else {
          story.UseSensorAngle();
        }
        const calibration::TraceResult traced = TraceAll(story.Collect());
        const ChannelTrace* channel = nullptr;
        for (const ChannelTrace& any : traced.channels)
          if (any.axis == SensorAxis::kZ) channel = &any;
        ASSERT_NE(channel, nullptr);
        EXPECT_NE(channel->verdict, calibration::Verdict::kCannotBe) << channel->summary;
        const auto& scale = channel->baseline.parameters.at(0);
        EXPECT_NEAR(scale.value, story.scale[2], 0.003)
            << channel->summary << " step " << step_deg << " deg, seed " << seed << of_stand;
        EXPECT_NEAR(scale.value, story.scale[2], 5.0 * scale.std_error) << channel->summary;
      }
    }
  }
}

// By a twentieth of a degree once a second, there and back: within the tolerance of a rest. The
// neighbours' rates say the opposite of what such a motion does.
TEST(ATableThatIsMovedBySmallSteps, HasTheScaleFactorOfTheGyro) {
  std::vector<Stretch> steps = {{0.0, 20.0}};
  for (int i = 0; i < 300; ++i) {
    steps.push_back({i / 40 % 2 == 0 ? 0.2 : -0.2, 0.125});
    steps.push_back({0.0, 0.625});
  }
  const SoftTurns turns(steps, 0.125);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Story story = TellOf(turns, {kSixteenBits_deg / 4.0, 0.0}, seed);
    story.UseTurningChannelAlone();
    const ChannelTrace channel = TraceOf(story.Collect());
    const auto& scale = channel.baseline.parameters.at(0);
    EXPECT_NEAR(scale.value, story.scale[2], 0.03) << channel.summary;
    EXPECT_NEAR(scale.value, story.scale[2], 5.0 * scale.std_error) << channel.summary;
  }
}

// Nothing that rests has turned by more than its readings can tell, and seven tenths of the time at
// rest are left.
TEST(ASoftRamp, IsNoPartOfARest) {
  const SoftTurns turns(kSlow, 3.0);
  for (const double noise_deg : {0.0003, 0.003}) {
    const calibration::Recording recording = TellOf(turns, {0.0, noise_deg}, 5).Collect();
    const calibration::StateHistory history = calibration::MakeStateHistory(
        recording, calibration::RoughSensitivity(recording), true, {});
    double rests_s = 0.0, turned_deg = 0.0;
    for (std::size_t i = 0; i < history.still.size(); ++i) {
      if (!history.still[i]) continue;
      const double from_s = history.epochs[i].at.t_s, to_s = history.epochs[i + 1].at.t_s;
      rests_s += to_s - from_s;
      turned_deg += std::fabs(turns.Angle(to_s) - turns.Angle(from_s));
    }
    // Twelve ends of rests.
    EXPECT_LT(turned_deg / 12.0, std::max(0.002, noise_deg)) << noise_deg;
    EXPECT_GT(rests_s, 0.7 * 34.0);
  }
}

Rest From(double begin_s, double end_s, double angle_deg) {
  Rest rest;
  rest.begin.t_s = rest.reference_begin_s = begin_s;
  rest.end.t_s = rest.reference_end_s = end_s;
  rest.rotation_deg = {0.0, 0.0, angle_deg};
  rest.count_deg = 0.088;
  return rest;
}

TEST(RestsThatFollowEachOtherLikeStairs, AreATurn) {
  for (const double direction : {1.0, -1.0}) {
    Columns columns;
    columns.rests = {From(0.0, 10.0, 0.0)};
    for (int i = 0; i < 20; ++i)
      columns.rests.push_back(From(11.0 + i, 11.9 + i, direction * 0.09 * i));
    columns.rests.push_back(From(32.0, 40.0, direction * 1.8));
    calibration::PartSlowTurns(&columns);
    EXPECT_EQ(columns.rests.size(), 2U);
    EXPECT_EQ(columns.slow_turns.size(), 20U);
  }
}

// A count to and fro, counts far apart, a pause between them, uneven ones, or steps of the table.
TEST(RestsThatFollowEachOtherLikeStairs, AreTheOnlyOnesThatTurn) {
  const std::vector<std::vector<Rest>> many = {
      {From(0, 1, 0.0), From(1, 2, 0.09), From(2, 3, 0.0), From(3, 4, 0.09), From(4, 5, 0.0)},
      {From(0, 20, 0.0), From(20, 40, 0.09), From(40, 60, 0.18)},
      {From(0, 1, 0.0), From(2, 3, 0.09), From(4, 5, 0.18)},
      {From(0, 1, 0.0), From(1, 2, 0.25), From(2, 3, 0.3)},
      {From(0, 1, 0.0), From(1, 2, 0.4), From(2, 3, 0.8), From(3, 4, 1.2)},
      {From(0, 3, 0.0), From(3, 4, 0.09), From(4, 7, 0.18), From(7, 8, 0.27), From(8, 11, 0.36)}};
  for (const std::vector<Rest>& rests : many) {
    Columns columns;
    columns.rests = rests;
    calibration::PartSlowTurns(&columns);
    EXPECT_EQ(columns.rests.size(), rests.size());
    EXPECT_TRUE(columns.slow_turns.empty());
  }
}

// Angles of nodes a tenth of a second apart.
struct Nodes {
  std::vector<double> t_s, read_deg, felt_deg;
  double error_deg, walk_deg_sqrt_s;

  template <typename Angle>
  Nodes(Angle angle, double error, double walk, std::uint64_t seed)
      : error_deg(error), walk_deg_sqrt_s(walk) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    double drift_deg = 0.0;
    for (int k = 0; k < 400; ++k) {
      t_s.push_back(5000.0 + 0.1 * k);
      read_deg.push_back(angle(0.1 * k) + error * normal(random));
      felt_deg.push_back(1.01 * angle(0.1 * k) + 0.02 * k + drift_deg);
      drift_deg += walk * std::sqrt(0.1) * normal(random);
    }
  }
  AngleSeries series() const { return {t_s, read_deg, felt_deg, error_deg, walk_deg_sqrt_s}; }
};

// By a line through 129 nodes: its error is sqrt(1 / n) of a node's, and that of the slope
// sqrt(12 / n^3) of it from node to node.
TEST(AnEvenTurn, IsKnownByManyReadings) {
  constexpr double kError_deg = 0.02, kNodes = 129.0, kRate_deg_s = 0.3, kNode_s = 0.1;
  double angle = 0.0, rate = 0.0, count = 0.0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Nodes nodes([](double t_s) { return kRate_deg_s * t_s; }, kError_deg, 0.004, seed);
    for (const std::size_t k : {100U, 250U}) {
      const auto turn = FindEvenTurn(nodes.series(), k, nodes.t_s[k], 0, 400);
      ASSERT_TRUE(turn) << seed;
      angle += std::pow(turn->angle_deg - kRate_deg_s * kNode_s * static_cast<double>(k), 2);
      rate += std::pow(turn->rate_deg_s - kRate_deg_s, 2);
      count += 1.0;
    }
  }
  // A standard deviation of 80 is good to 8 %; four of that, and some lines are shorter by chance.
  EXPECT_NEAR(std::sqrt(angle / count), kError_deg / std::sqrt(kNodes), 0.35 * 0.0018);
  EXPECT_NEAR(std::sqrt(rate / count), kError_deg * std::sqrt(12.0 / std::pow(kNodes, 3)) / kNode_s,
              0.35 * 4.8e-4);
}

// Of a swing that the readings hide the gyro tells what a line would miss: the rate that is found
// keeps to it within what its readings allow.
TEST(AnEvenTurn, FollowsWhatTheGyroFeels) {
  constexpr double kAmplitude_deg_s = 0.6, kError_deg = 0.02;
  for (const double period_s : {5.0, 20.0, 80.0}) {
    const double omega = 2.0 * std::numbers::pi / period_s;
    const auto angle = [&](double t_s) {
      return kAmplitude_deg_s / omega * (1.0 - std::cos(omega * t_s));
    };
    double square = 0.0, count = 0.0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const Nodes nodes(angle, kError_deg, 0.004, seed);
      for (std::size_t k = 70; k < 330; k += 20) {
        const auto turn = FindEvenTurn(nodes.series(), k, nodes.t_s[k], 0, 400);
        if (!turn) continue;
        const double rate = kAmplitude_deg_s * std::sin(0.1 * omega * static_cast<double>(k));
        square += std::pow(turn->rate_deg_s - rate, 2);
        count += 1.0;
      }
    }
    EXPECT_GT(count, 100.0) << period_s;
    // Two readings next to each other tell it to 0.28 deg/s, six rates about it to 0.07.
    EXPECT_LT(std::sqrt(square / count), 0.03) << period_s;
  }
}

TEST(AnEvenTurn, IsLeftToReadingsThatTellIt) {
  const Nodes fast([](double t_s) { return 30.0 * t_s; }, 0.002, 0.004, 1);
  EXPECT_FALSE(FindEvenTurn(fast.series(), 200, fast.t_s[200], 0, 400));
  const Nodes slow([](double t_s) { return 0.3 * t_s; }, 0.002, 0.004, 1);
  EXPECT_TRUE(FindEvenTurn(slow.series(), 200, slow.t_s[200], 0, 400));
  EXPECT_FALSE(FindEvenTurn(slow.series(), 7, slow.t_s[7], 0, 15)) << "too few";
}

}  // namespace
}  // namespace gyrobench::testing
