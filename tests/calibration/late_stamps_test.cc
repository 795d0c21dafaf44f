// Stamps that are late by a random time: the angle errs by more the faster it turns.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "calibration/state/timing_error.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::AngleBesideGyro;
using calibration::AngleErrors;
using calibration::FindAngleErrors;

constexpr double kReading_deg = 0.003;

// Means of so many readings, each at a time of its own, beside the mean of so many others.
struct Drawn {
  double timing_s = 0.0, readings = 1.0, beside = 6.0;
};

std::vector<AngleBesideGyro> Draw(const Drawn& drawn, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::exponential_distribution<double> late(1.0);
  std::normal_distribution<double> normal;
  std::vector<AngleBesideGyro> out;
  for (const double rate_deg_s : {5.0, 10.0, 20.0, -20.0, 40.0}) {
    const auto error_deg = [&](double count) {
      double sum = 0.0;
      for (int i = 0; i < static_cast<int>(count); ++i)
        sum += kReading_deg * normal(random) - rate_deg_s * drawn.timing_s * (late(random) - 1.0);
      return sum / count;
    };
    for (int node = 0; node < 400; ++node) {
      double others = 0.0;
      for (int k = 0; k < static_cast<int>(drawn.beside); ++k)
        others += error_deg(drawn.readings) / drawn.beside;
      out.push_back({error_deg(drawn.readings) - others, rate_deg_s, drawn.readings, drawn.beside});
    }
  }
  return out;
}

TEST(TimesOfReadings, AreAsFarOffAsTheAngleErrsByTheRate) {
  for (const double timing_s : {0.0002, 0.001, 0.003}) {
    for (const double readings : {1.0, 4.0}) {
      double sum = 0.0;
      constexpr int kSeeds = 20;
      for (int seed = 0; seed < kSeeds; ++seed) {
        const auto number = static_cast<std::uint64_t>(seed);
        sum += std::sqrt(FindAngleErrors(Draw({timing_s, readings}, number)).timing_s2);
      }
      EXPECT_NEAR(sum / kSeeds, timing_s, 0.1 * timing_s) << readings << " readings";
    }
  }
}

TEST(TimesOfReadings, AreRightWhereTheErrorsDoNotGrow) {
  for (std::uint64_t seed = 0; seed < 200; ++seed)
    EXPECT_EQ(FindAngleErrors(Draw({0.0, 1.0}, seed)).timing_s2, 0.0) << seed;
}

TEST(TimesOfReadings, AreNotToldFromOneSpeed) {
  std::vector<AngleBesideGyro> at_one_speed = Draw({0.001}, 1);
  std::erase_if(at_one_speed, [](const AngleBesideGyro& a) { return a.rate_deg_s != 40.0; });
  EXPECT_EQ(FindAngleErrors(at_one_speed).timing_s2, 0.0);
}

// In a column that depends on the angle an error that the output has as well would be found as a
// wave of it. The gyro carries the angle to a stamp that is off, the reading has noise: the mean of
// both by the share is off from where the table was, but not as the output is.
TEST(AnAngleWithTheShareOfItsReading, HasNoErrorOfTheOutput) {
  constexpr double kTiming_s = 0.0004;
  const AngleErrors errors{kReading_deg * kReading_deg, kTiming_s * kTiming_s};
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (const double rate_deg_s : {3.0, 8.0, 20.0}) {
    double together = 0.0, angle = 0.0, output = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const double noise_deg = kReading_deg * normal(random);
      const double turned_deg = rate_deg_s * kTiming_s * normal(random);
      // The table is at 0 when it is read, and at `turned_deg` at the stamp.
      const double off_deg = noise_deg - turned_deg;
      const double angle_deg = turned_deg + errors.ShareOfTiming(rate_deg_s, 1.0) * off_deg;
      together += angle_deg * off_deg;
      angle += angle_deg * angle_deg;
      output += off_deg * off_deg;
    }
    EXPECT_LT(std::fabs(together), 4.5 * std::sqrt(angle * output / 20000.0)) << rate_deg_s;
    EXPECT_LT(angle, output);
  }
}

// At whole degrees for each reading, a wave of many periods a turn has one value while the table
// turns and others on its ramps.
Motion RoundSpeeds() {
  Motion motion;
  for (int round = 0; round < 3; ++round) {
    for (const double rate : {10.0, 20.0, 40.0}) motion.ThereAndBack(kInnerAxis, 360.0, rate);
  }
  return motion;
}

// Each reading shows the angle of an exponential time before its stamp, about their mean.
calibration::Recording MeasureLate(Injection injection, std::uint64_t seed) {
  constexpr double kLate_s = 0.001;
  BenchSensor sensor;
  sensor.reading_deg = 0.001;
  auto random = std::make_shared<std::mt19937_64>(seed + 100);
  injection.shown_s = [random](double t_s) {
    return t_s - kLate_s * (std::exponential_distribution<double>(1.0)(*random) - 1.0);
  };
  return SyntheticBench(RoundSpeeds(), sensor).Measure(injection, seed);
}

TEST(LateStamps, AreNoEffectAndAreSaid) {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const calibration::ChannelTrace channel = TraceOf(MeasureLate({}, seed));
    EXPECT_TRUE(channel.effects.empty()) << channel.summary << ", seed " << seed;
    std::string remarks;
    for (const std::string& remark : channel.remarks) remarks += remark + "\n";
    EXPECT_NE(remarks.find("the times of its readings were off by"), std::string::npos) << remarks;
  }
}

TEST(LateStamps, HideNoWaveThatIsThere) {
  constexpr double kWave_deg = 0.02, kPeriods = 60.0;
  const double per_deg = kPeriods * std::acos(-1.0) / 180.0;
  Injection wave;
  wave.angle_deg = [per_deg](const BenchState& state) {
    return kWave_deg * std::sin(per_deg * state.table.angle_deg[kInnerAxis]);
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const calibration::ChannelTrace channel = TraceOf(MeasureLate(wave, seed));
    ASSERT_EQ(NamesOf(channel), std::vector<std::string>{"angle.ripple"}) << "seed " << seed;
    ExpectWithinItsInterval(channel.effects[0].parameters, {"amplitude_inner", kWave_deg});
  }
}

}  // namespace
}  // namespace gyrobench::testing
