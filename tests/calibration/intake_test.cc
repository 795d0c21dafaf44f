// What intake says of sound samples of every kind of sensor, and of unsound ones: saturation and
// freezes are found where they are, and nothing that was measured is called one.
#include "calibration/signal/intake.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <set>
#include <string>

#include "calibration/signal/collector.h"
#include "calibration/signal/gyro_stream.h"

namespace gyrobench::testing {
namespace {

using calibration::BadStretch;
using calibration::Collector;
using calibration::GyroStream;
using calibration::Recording;

// Rests of 3 s, turns about z to and fro at up to 60 deg/s, soft ramps.
double Rate_deg_s(double t_s, double top_deg_s) {
  const double in_cycle_s = std::fmod(t_s, 6.0);
  if (in_cycle_s < 3.0) return 0.0;
  const double sign = std::fmod(t_s, 12.0) < 6.0 ? 1.0 : -1.0;
  return sign * top_deg_s *
         std::clamp(std::min(in_cycle_s - 3.0, 6.0 - in_cycle_s) / 0.6, 0.0, 1.0);
}

double Angle_deg(double t_s, double top_deg_s) {
  constexpr int kSteps = 400;
  static double last_t_s = 0.0, angle_deg = 0.0;
  if (t_s <= last_t_s) last_t_s = angle_deg = 0.0;
  const double step_s = (t_s - last_t_s) / kSteps;
  for (int k = 0; k < kSteps; ++k)
    angle_deg += Rate_deg_s(last_t_s + (k + 0.5) * step_s, top_deg_s) * step_s;
  last_t_s = t_s;
  return angle_deg;
}

// A bench as the classes of users' benches differ.
struct Bench {
  double duration_s = 60.0;
  double gyro_hz = 100.0, reference_hz = 100.0;
  double noise_deg_s = 0.05;
  double digit_deg_s = 1.0 / 131.0;  // of the gyro's output
  double time_digit_s = 1e-6;
  double offset_deg_s = 2.0;
  double top_deg_s = 60.0;
  double reference_digit_deg = 1e-4, reference_noise_deg = 0.004;
  RateUnit unit = RateUnit::kLsb;
  double zero_lsb = 0.0;             // of the converter
  std::optional<double> given_zero;  // as the table says
  bool sensitivity_given = true;
  double low_lsb = -32768.0, high_lsb = 32767.0;
  std::function<void(double, GyroSample*)> spoil;
  std::uint64_t seed = 1;
};

MeasurementInfo InfoOf(const Bench& bench) {
  MeasurementInfo info;
  info.source = "bench.csv";
  info.gyro_unit = bench.unit;
  info.gyro_present = {true, true, true};
  info.gyro_units_per_deg_s = bench.unit == RateUnit::kLsb            ? 1.0 / bench.digit_deg_s
                              : bench.unit == RateUnit::kDegPerSecond ? 1.0
                                                                      : std::numbers::pi / 180.0;
  if (bench.unit == RateUnit::kLsb && !bench.sensitivity_given) info.gyro_units_per_deg_s.reset();
  info.gyro_lsb_zero = bench.given_zero;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {false, false, true};
  return info;
}

double Output(const Bench& bench, double rate_deg_s) {
  const double digits = std::round(rate_deg_s / bench.digit_deg_s);
  if (bench.unit == RateUnit::kLsb)
    return std::clamp(digits + bench.zero_lsb, bench.low_lsb, bench.high_lsb) -
           bench.given_zero.value_or(0.0);
  return digits * bench.digit_deg_s *
         (bench.unit == RateUnit::kRadPerSecond ? std::numbers::pi / 180.0 : 1.0);
}

Recording Measure(const Bench& bench) {
  Collector collector;
  collector.OnInfo(InfoOf(bench));
  std::mt19937_64 random(bench.seed);
  std::normal_distribution<double> normal;
  const auto stamp = [&](double t_s) {
    return std::floor(t_s / bench.time_digit_s + 0.5) * bench.time_digit_s;
  };
  std::int64_t reading = 0;
  Angle_deg(0.0, bench.top_deg_s);
  for (std::int64_t i = 0; static_cast<double>(i) < bench.duration_s * bench.gyro_hz; ++i) {
    const double t_s = static_cast<double>(i) / bench.gyro_hz;
    for (; static_cast<double>(reading) / bench.reference_hz <= t_s; ++reading) {
      const double at_s = static_cast<double>(reading) / bench.reference_hz;
      const double angle =
          Angle_deg(at_s, bench.top_deg_s) + bench.reference_noise_deg * normal(random);
      collector.OnAngle(
          {stamp(at_s), 2,
           std::round(angle / bench.reference_digit_deg) * bench.reference_digit_deg});
    }
    GyroSample sample;
    sample.t_s = stamp(t_s);
    for (std::size_t c = 0; c < 3; ++c) {
      const double turned = c == 2 ? Rate_deg_s(t_s, bench.top_deg_s) : 0.0;
      const double own = bench.offset_deg_s * (c == 1 ? -1.0 : 1.0);
      sample.xi[c] = Output(bench, turned + own + bench.noise_deg_s * normal(random));
    }
    if (bench.spoil) bench.spoil(t_s, &sample);
    collector.OnGyro(sample);
  }
  return collector.Take();
}

std::int64_t Count(const Recording& recording, const std::string& kind) {
  std::int64_t count = 0;
  for (const Defect& defect : recording.defects) count += defect.kind == kind ? defect.count : 0;
  return count;
}

double Masked_s(const Recording& recording) {
  double sum_s = 0.0;
  for (const BadStretch& bad : recording.columns.bad) sum_s += bad.end_s - bad.begin_s;
  return sum_s;
}

void ExpectSound(const Bench& bench, const char* what) {
  SCOPED_TRACE(what);
  const Recording recording = Measure(bench);
  for (const Defect& defect : recording.defects)
    ADD_FAILURE() << defect.kind << " " << defect.count << " first at " << defect.first_t_s << " "
                  << defect.where;
  EXPECT_EQ(Masked_s(recording), 0.0);
  // Ten rests of 3 s, less what their edges cost.
  EXPECT_GE(recording.columns.rests.size(), 9u);
}

Bench Unsigned16() {
  Bench bench;
  bench.zero_lsb = 32768.0;
  bench.low_lsb = 0.0;
  bench.high_lsb = 65535.0;
  return bench;
}

TEST(SoundSamples, AreNotMaskedWhateverTheGyrosRate) {
  Bench bench;
  bench.gyro_hz = 20.0;
  bench.duration_s = 72.0;
  ExpectSound(bench, "20 Hz");
  bench.gyro_hz = bench.reference_hz = 1000.0;
  ExpectSound(bench, "1 kHz");
  bench.time_digit_s = 1e-3;
  ExpectSound(bench, "1 kHz with stamps in milliseconds");
}

TEST(SoundSamples, AreNotFrozenWhereTheDigitIsCoarserThanTheNoise) {
  Bench bench;
  bench.digit_deg_s = 0.1;
  bench.noise_deg_s = 0.01;
  for (const double offset : {0.0, 0.03, 2.02, -17.0}) {
    bench.offset_deg_s = offset;
    ExpectSound(bench, "counts of 0.1 deg/s");
    bench.noise_deg_s = 0.03;
    ExpectSound(bench, "counts of 0.1 deg/s with some noise");
    bench.noise_deg_s = 0.01;
  }
  bench.unit = RateUnit::kDegPerSecond;
  ExpectSound(bench, "deg/s with one decimal");
}

// A steady turn shows one value over and over where the digit is coarse.
TEST(SoundSamples, AreNotSaturatedOnASteadyTurnWithACoarseDigit) {
  Bench bench;
  bench.unit = RateUnit::kDegPerSecond;
  bench.digit_deg_s = 0.1;
  bench.noise_deg_s = 0.01;
  for (const double top : {120.0, 200.0, 250.0}) {
    bench.top_deg_s = top;
    ExpectSound(bench, "steady turn");
  }
}

TEST(SoundSamples, OfOtherUnitsOffsetsAndReferencesAreNotMasked) {
  Bench bench;
  bench.unit = RateUnit::kRadPerSecond;
  bench.digit_deg_s = 1e-4 * 180.0 / std::numbers::pi;
  ExpectSound(bench, "rad/s with four decimals");
  bench = {};
  bench.offset_deg_s = 20.0;
  ExpectSound(bench, "an offset of 20 deg/s");
  bench = {};
  bench.reference_digit_deg = 360.0 / 4096.0;
  ExpectSound(bench, "12 bits of the reference");
  bench.reference_noise_deg = 0.0;
  ExpectSound(bench, "12 bits of the reference, no noise");
  bench = {};
  bench.reference_hz = 500.0;
  ExpectSound(bench, "a reference five times faster");
  bench.gyro_hz = 20.0;
  bench.duration_s = 72.0;
  ExpectSound(bench, "a reference twenty-five times faster");
}

TEST(SoundSamples, OfConvertersOfEveryWidthAreNotSaturated) {
  struct Width {
    double bits, digit_deg_s;
  };
  for (const Width& width : {Width{12, 0.25}, Width{14, 0.05}, Width{18, 2e-3}, Width{20, 5e-4},
                             Width{24, 3e-5}, Width{32, 1e-7}}) {
    SCOPED_TRACE(width.bits);
    Bench bench;
    bench.digit_deg_s = width.digit_deg_s;
    const double half = std::ldexp(1.0, static_cast<int>(width.bits) - 1);
    bench.low_lsb = -half;
    bench.high_lsb = half - 1.0;
    ExpectSound(bench, "signed");
    bench.zero_lsb = half;
    bench.low_lsb = 0.0;
    bench.high_lsb = 2.0 * half - 1.0;
    ExpectSound(bench, "unsigned, undeclared");
    bench.given_zero = half;
    ExpectSound(bench, "unsigned, declared");
  }
}

// The stream tells those who keep no sample.
TEST(UnsignedCounts, AreRecognisedInTheStreamWhereNobodyGaveTheirZero) {
  const auto stream = [](double zero, std::optional<double> given) {
    MeasurementInfo info;
    info.gyro_present = {true, true, true};
    info.gyro_lsb_zero = given;
    GyroStream out;
    out.Start(info);
    for (int i = 0; i < 200; ++i) {
      const double count = zero - given.value_or(0.0) + 50.0 * std::sin(0.1 * i);
      out.Add({0.01 * i, {count, count, count}});
    }
    return out.unsigned_counts();
  };
  EXPECT_TRUE(stream(32768.0, {}));
  EXPECT_FALSE(stream(32768.0, 32768.0));
  EXPECT_FALSE(stream(0.0, {}));
  EXPECT_FALSE(stream(30000.0, {})) << "never on both sides";
}

TEST(UnsignedCounts, AreNotSaturatedBecauseTheyPassTheEndOfASignedRange) {
  Bench bench = Unsigned16();
  ExpectSound(bench, "undeclared");
  bench.given_zero = 32768.0;
  ExpectSound(bench, "declared");
  // One that rests at its very middle.
  bench = Unsigned16();
  bench.offset_deg_s = 0.0;
  bench.digit_deg_s = 0.1;
  bench.noise_deg_s = 0.01;
  ExpectSound(bench, "coarse, at its middle");
}

// The turn goes to 60 deg/s; what the converter's end leaves of it is masked, on the turns alone.
void ExpectSaturation(const Bench& bench, double limit_deg_s, const char* what) {
  SCOPED_TRACE(what);
  const Recording recording = Measure(bench);
  const double steep_s = 0.6 * limit_deg_s / 60.0;
  const double expected_s = 10.0 * (3.0 - 2.0 * steep_s) * bench.duration_s / 60.0;
  EXPECT_GT(Count(recording, "saturation"), 0);
  EXPECT_NEAR(Masked_s(recording), expected_s, 0.15 * expected_s);
  for (const BadStretch& bad : recording.columns.bad) {
    EXPECT_TRUE(bad.channel[2]);
    EXPECT_FALSE(bad.channel[0] || bad.channel[1]);
    EXPECT_GT(std::fabs(Rate_deg_s(0.5 * (bad.begin_s + bad.end_s), 60.0)), 0.8 * limit_deg_s);
  }
}

TEST(Saturation, IsFoundAtTheEndsOfConvertersOfEveryWidth) {
  for (const double bits : {12.0, 14.0, 16.0, 18.0, 20.0, 24.0, 32.0}) {
    SCOPED_TRACE(bits);
    const double half = std::ldexp(1.0, static_cast<int>(bits) - 1);
    Bench bench;
    bench.offset_deg_s = 1.0;
    bench.digit_deg_s = 50.0 / half;
    bench.low_lsb = -half;
    bench.high_lsb = half - 1.0;
    ExpectSaturation(bench, 50.0, "signed");
    bench.zero_lsb = half;
    bench.low_lsb = 0.0;
    bench.high_lsb = 2.0 * half - 1.0;
    bench.given_zero = half;
    ExpectSaturation(bench, 50.0, "unsigned, declared");
    if (bits != 16.0) continue;
    bench.given_zero.reset();
    ExpectSaturation(bench, 50.0, "unsigned, undeclared");
    bench.sensitivity_given = false;
    ExpectSaturation(bench, 50.0, "unsigned, nothing declared");
  }
}

// 100 samples at the end of 16 bits, then one beyond: the counts are wider.
TEST(Saturation, IsTakenBackWhenCountsGoBeyondTheEnd) {
  GyroStream stream;
  MeasurementInfo info;
  info.gyro_present = {true, false, false};
  stream.Start(info);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 5.0);
  auto add = [&, i = 0](double value) mutable {
    GyroSample sample;
    sample.t_s = 0.01 * i++;
    sample.xi[0] = value;
    stream.Add(sample);
  };
  for (int i = 0; i < 100; ++i) add(std::round(noise(random)));
  for (int i = 0; i < 100; ++i) add(32767.0);
  EXPECT_FALSE(stream.bad().empty());
  for (int i = 0; i < 100; ++i) add(40000.0 + std::round(noise(random)));
  EXPECT_TRUE(stream.bad().empty());
  EXPECT_TRUE(stream.defects().empty());
}

// A sensor whose noise shows, hung for 2 s in a rest and for 1 s in a turn.
TEST(Freeze, IsFoundWhereTheNoiseWouldHaveShown) {
  for (const double digit : {1.0 / 131.0, 0.03, 0.06}) {
    SCOPED_TRACE(digit);
    Bench bench;
    bench.digit_deg_s = digit;
    bench.noise_deg_s = std::max(0.05, 1.5 * digit);
    GyroSample held;
    bench.spoil = [&](double t_s, GyroSample* sample) {
      const bool hung = (t_s > 24.5 && t_s < 26.5) || (t_s > 40.0 && t_s < 41.95);
      if (!hung) held = *sample;
      sample->xi = held.xi;
    };
    const Recording recording = Measure(bench);
    EXPECT_NEAR(Masked_s(recording), 3.95, 0.1);
    EXPECT_GT(Count(recording, "frozen"), 150);
    EXPECT_FALSE(recording.columns.bad.empty());
    if (recording.columns.bad.empty()) continue;
    EXPECT_NEAR(recording.columns.bad.front().begin_s, 24.5, 0.1);
    EXPECT_NEAR(recording.columns.bad.front().end_s, 26.5, 0.1);
  }
}

TEST(Freeze, OfACoarseSensorIsFoundWhereItWakesInTheMiddleOfAMotion) {
  Bench bench;
  bench.digit_deg_s = 0.1;
  bench.noise_deg_s = 0.01;
  GyroSample held;
  bench.spoil = [&](double t_s, GyroSample* sample) {
    if (t_s < 28.0 || t_s > 30.5) held = *sample;
    sample->xi = held.xi;
  };
  const Recording recording = Measure(bench);
  // It had stood at that value from the begin of the steady turn, at 27.6 s.
  EXPECT_NEAR(Masked_s(recording), 2.7, 0.3);
}

TEST(Recording, InWhichTheUnitStartedAnewBelongsToNoOnePowerOn) {
  MeasurementInfo info;
  info.power_on = "A";
  Collector collector;
  collector.OnInfo(info);
  EXPECT_EQ(collector.Take().info.power_on, "A");
  for (int i = 0; i < 9; ++i) collector.OnTickPair({40.0 + i, 1.002 * i});
  collector.OnDefect({kUnitRestarted, 1, 7.0, ""});
  for (int i = 0; i < 9; ++i) collector.OnTickPair({60.0 + i, 100.0 + 1.002 * i});
  const Recording recording = collector.Take();
  EXPECT_EQ(recording.info.power_on, "");
  EXPECT_NEAR(recording.ticks.ratio(), 1.002, 1e-12) << "of either part, and not across both";
  const std::vector<std::string> remarks = calibration::IntakeRemarks(recording);
  ASSERT_EQ(remarks.size(), 1u);
  EXPECT_NE(remarks[0].find("started anew within the measurement (1 times, first at 7.0 s)"),
            std::string::npos)
      << remarks[0];
}

}  // namespace
}  // namespace gyrobench::testing
