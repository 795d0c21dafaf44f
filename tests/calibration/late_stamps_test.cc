// Stamps that are late by a random time: the angle errs by more the faster it turns.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "calibration/state/state_history.h"
#include "calibration/state/timing_error.h"
#include "calibration/trace/trace.h"
#include "tests/calibration/injected.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {
namespace {

using calibration::SteadyAngle;

constexpr double kReading_deg = 0.003;

// A table that turns there and back at each speed, with one reading a tenth of a second.
struct Readings {
  double timing_s = 0.0;
  double wave_deg = 0.0, periods = 36.0;  // of the reference
  double step_deg = 0.0;                  // that it is rounded to
  double noise_deg = kReading_deg;
  std::vector<double> speeds_deg_s = {5.0, 10.0, 20.0, 40.0};
  int passes = 6;
};

class Table {
 public:
  Table(const Readings& readings, std::uint64_t seed) : readings_(readings), random_(seed) {}

  // What each angle is off from a mean of its three neighbours on either side.
  std::vector<SteadyAngle> Steady() {
    std::vector<SteadyAngle> out;
    for (const double speed : readings_.speeds_deg_s) {
      for (int pass = 0; pass < readings_.passes; ++pass)
        Pass(pass % 2 == 0 ? speed : -speed, &out);
    }
    return out;
  }

 private:
  void Pass(double rate_deg_s, std::vector<SteadyAngle>* out) {
    constexpr double kInterval_s = 0.1;
    constexpr std::size_t kBeside = 3;
    const double from_deg = std::uniform_real_distribution<double>(0.0, 5.0)(random_);
    std::vector<double> angles, errors;
    for (double way = 0.0; way < 355.0; way += std::fabs(rate_deg_s) * kInterval_s) {
      angles.push_back(rate_deg_s > 0.0 ? from_deg + way : from_deg + 355.0 - way);
      errors.push_back(Error(angles.back(), rate_deg_s));
    }
    place_ += 100;
    for (std::size_t k = kBeside; k + kBeside < angles.size(); ++k) {
      double beside = 0.0;
      for (std::size_t d = 1; d <= kBeside; ++d) beside += errors[k - d] + errors[k + d];
      out->push_back({.residual_deg = errors[k] - beside / (2.0 * kBeside),
                      .rate_deg_s = rate_deg_s,
                      .angle_deg = angles[k],
                      .neighbours = 2.0 * kBeside,
                      .place = place_ + k});
    }
    place_ += angles.size();
  }
  double Error(double angle_deg, double rate_deg_s) {
    const double late_s =
        readings_.timing_s * (std::exponential_distribution<double>(1.0)(random_) - 1.0);
    const double wave = std::sin(readings_.periods * angle_deg * std::acos(-1.0) / 180.0);
    const double read_deg = angle_deg - rate_deg_s * late_s + readings_.wave_deg * wave +
                            readings_.noise_deg * std::normal_distribution<double>()(random_);
    const double step_deg = readings_.step_deg;
    return (step_deg > 0.0 ? step_deg * std::round(read_deg / step_deg) : read_deg) - angle_deg;
  }

  Readings readings_;
  std::mt19937_64 random_;
  std::size_t place_ = 0;
};

std::optional<calibration::AngleErrors> ErrorsOf(const Readings& readings, std::uint64_t seed) {
  return calibration::FindAngleErrors(Table(readings, seed).Steady(), readings.step_deg);
}

// In how many of so many tables the times pass for wrong; in all of them they can be told.
int TimesPassForWrong(const Readings& readings, int tables) {
  int wrong = 0;
  for (int seed = 0; seed < tables; ++seed) {
    const auto errors = ErrorsOf(readings, static_cast<std::uint64_t>(seed));
    EXPECT_TRUE(errors.has_value());
    if (errors && errors->timing_s2 > 0.0) ++wrong;
  }
  return wrong;
}

TEST(TimesOfReadings, AreAsFarOffAsTheAngleErrsByTheRate) {
  for (const double timing_s : {0.0003, 0.001, 0.01}) {
    double sum_s = 0.0;
    constexpr int kSeeds = 20;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed)
      sum_s += std::sqrt(ErrorsOf({.timing_s = timing_s}, seed)->timing_s2);
    EXPECT_NEAR(sum_s / kSeeds, timing_s, 0.15 * timing_s);
  }
}

TEST(TimesOfReadings, AreRightWhereTheErrorsDoNotGrow) {
  for (const double noise_deg : {0.0005, 0.003, 0.02, 0.05}) {
    EXPECT_EQ(TimesPassForWrong({.noise_deg = noise_deg}, 50), 0) << noise_deg;
    EXPECT_EQ(TimesPassForWrong({.noise_deg = noise_deg, .speeds_deg_s = {2, 5, 10, 20}}, 50), 0);
  }
}

TEST(TimesOfReadings, AreRightWhereTheReferenceHasAWave) {
  for (const double wave_deg : {0.004, 0.02, 0.3}) {
    for (const double periods : {2.0, 8.0, 36.0, 60.0, 200.0}) {
      const Readings readings{.wave_deg = wave_deg, .periods = periods};
      EXPECT_LE(TimesPassForWrong(readings, 20), 1) << wave_deg << " deg, " << periods;
    }
  }
}

TEST(TimesOfReadings, AreRightWhereTheReferenceIsRounded) {
  for (const double step_deg : {0.005, 0.02, 0.1}) {
    const Readings readings{
        .step_deg = step_deg, .noise_deg = 0.002, .speeds_deg_s = {1.03, 3.07, 9.71, 21.3}};
    EXPECT_LE(TimesPassForWrong(readings, 20), 1) << step_deg;
  }
}

TEST(TimesOfReadings, AreNotToldFromOneSpeed) {
  const Readings readings{.timing_s = 0.001, .speeds_deg_s = {40.0}};
  EXPECT_FALSE(ErrorsOf(readings, 1).has_value());
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
    EXPECT_NE(remarks.find("the times of its readings were wrong by"), std::string::npos)
        << remarks;
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

// What a history says of the times of readings that are right.
double TimingErrorOf(const Motion& motion, const BenchSensor& sensor, const Injection& injection,
                     std::uint64_t seed) {
  const calibration::Recording recording = SyntheticBench(motion, sensor).Measure(injection, seed);
  return calibration::MakeStateHistory(recording, calibration::RoughSensitivity(recording), true,
                                       {})
      .timing_error_s;
}

TEST(StampsThatAreRight, AreNotSaidToBeLate) {
  Injection play;
  play.angle_deg = [](const BenchState& state) {
    return state.table.rate_deg_s[kInnerAxis] < 0.0 ? 0.03 : 0.0;
  };
  const Injection injections[] = {{}, play};
  for (const double reading_deg : {0.001, 0.02}) {
    BenchSensor sensor;
    sensor.reading_deg = reading_deg;
    for (const Motion& motion : {EveryMotion(), ManySpeeds(), RoundSpeeds()}) {
      for (const Injection& injection : injections) {
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
          const double timing_s = TimingErrorOf(motion, sensor, injection, seed);
          EXPECT_FALSE(timing_s > 0.0) << timing_s << " s, " << reading_deg << " deg, " << seed;
        }
      }
    }
  }
}

}  // namespace
}  // namespace gyrobench::testing
