// Numbers of the baseline for sensors that are mounted and built in unusual ways, against what was
// put into the measurement.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/trace/trace.h"
#include "tests/calibration/synthetic_bench.h"
#include "tests/calibration/trace_story.h"

namespace gyrobench::testing {
namespace {

using calibration::ChannelTrace;
using calibration::ModelParameter;
using calibration::Recording;
using calibration::Traced;
using ::testing::HasSubstr;

Traced TraceOf(const std::vector<const Story*>& stories) {
  std::vector<Recording> recordings;
  for (const Story* story : stories) recordings.push_back(story->Collect());
  std::vector<const Recording*> list;
  for (const Recording& recording : recordings) list.push_back(&recording);
  return calibration::Trace(list);
}

void ExpectNoEffect(const Traced& traced) {
  for (const ChannelTrace& channel : traced.result.channels) {
    for (const auto& effect : channel.effects)
      ADD_FAILURE() << effect.id << " (" << channel.summary << ")";
  }
}

void ExpectWithinItsInterval(const ChannelTrace& channel, const std::string& name, double value) {
  const auto& parameters = channel.baseline.parameters;
  const auto found = std::ranges::find(parameters, name, &ModelParameter::name);
  ASSERT_NE(found, parameters.end()) << "no parameter " << name;
  EXPECT_NEAR(found->value, value, 4.0 * found->std_error) << name;
  EXPECT_LT(found->std_error, 0.02 * std::fabs(value)) << name;
}

TEST(TraceOfASensorUpsideDown, HasANegativeScaleFactorAndNoEffect) {
  Story story;
  story.scale = {0.004, -0.003, -1.012};
  const Traced traced = TraceOf({&story});
  ExpectNoEffect(traced);
  ExpectWithinItsInterval(traced.result.channels[2], "scale_factor", -1.012);
  EXPECT_LT(traced.models[2].m_row[2], 0.0);
}

TEST(TraceOfABiasThatFallsWithTemperature, HasANegativeSlope) {
  for (const double slope : {-0.01, 0.01}) {
    Story story;
    story.drift_deg_s_per_degC = slope;
    const Traced traced = TraceOf({&story});
    ExpectNoEffect(traced);
    // The slope at half the range, which the higher orders bend a little.
    const calibration::ChannelModel& model = traced.models[2];
    const double low = model.min_temperature_degC, high = model.max_temperature_degC;
    const auto bias = [&](double degC) {
      double sum = 0.0;
      for (std::size_t k = 0; k < model.bias_deg_s.size(); ++k)
        sum += model.bias_deg_s[k] * std::pow(degC - model.reference_degC, static_cast<double>(k));
      return sum;
    };
    EXPECT_NEAR((bias(high) - bias(low)) / (high - low), slope, 0.1 * std::fabs(slope));
  }
}

// Turns of 9 deg and back, seen through a lag of first order and a delay.
class LaggedTurns {
 public:
  static constexpr double kLag_s = 0.0036, kDelay_s = 0.0012;

  LaggedTurns() {
    const auto rate = [](double t_s) {
      return std::max(0.0, std::min({20.0, 80.0 * t_s, 80.0 * (kTurn_s - t_s)}));
    };
    double angle = 0.0, shown = 0.0;
    for (int k = 0; k < kSteps; ++k) {
      angle_.push_back(angle);
      shown_.push_back(shown);
      const double middle = rate((k + 0.5) * kStep_s);
      angle += kStep_s * middle;
      shown += -std::expm1(-kStep_s / kLag_s) * (middle - shown);
    }
  }
  double ShownRate(double t_s) const {
    const auto [turns, in_turn_s, back] = At(t_s - kDelay_s);
    return (back ? -1.0 : 1.0) * Value(shown_, in_turn_s);
  }
  double Angle(double t_s) const {
    const auto [turns, in_turn_s, back] = At(t_s);
    const double made = turns * angle_.back() + Value(angle_, in_turn_s);
    return back ? 2.0 * kTurns * angle_.back() - made : made;
  }
  static double duration_s() { return 2.0 * kTurns * kPeriod_s; }

 private:
  static constexpr int kTurns = 40, kSteps = 16000;
  static constexpr double kStep_s = 5e-5, kTurn_s = 0.7, kRest_s = 2.0,
                          kPeriod_s = kTurn_s + kRest_s;
  struct Place {
    double turns, in_turn_s;
    bool back;
  };
  static Place At(double t_s) {
    const double turns = std::floor(std::max(t_s, 0.0) / kPeriod_s);
    return {turns, t_s - turns * kPeriod_s - kRest_s, turns >= kTurns};
  }
  static double Value(const std::vector<double>& values, double t_s) {
    const double place = std::clamp(t_s / kStep_s, 0.0, kSteps - 2.0), below = std::floor(place);
    const auto k = static_cast<std::size_t>(below);
    return values[k] + (place - below) * (values[k + 1] - values[k]);
  }
  std::vector<double> angle_, shown_;
};

// What is declared is the delay; the shape of the filter is in the angles within a turn, and must
// not come out as another scale factor.
TEST(TraceOfAFilterWhoseDelayIsDeclared, HasTheScaleFactorOfTheSensor) {
  constexpr int kSeeds = 6;
  const LaggedTurns turns;
  double sum = 0.0, variance = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Story story;
    story.seed = seed;
    story.duration_s = LaggedTurns::duration_s();
    story.gyro_hz = 200.0;
    story.reference_hz = 50.0;
    story.white_deg_s = 0.05;
    story.info.gyro_delay_s = LaggedTurns::kLag_s + LaggedTurns::kDelay_s;
    story.rate_deg_s = [&](double t_s) { return turns.ShownRate(t_s); };
    story.angle_deg = [&](double t_s) { return turns.Angle(t_s); };
    const Traced traced = TraceOf({&story});
    ExpectNoEffect(traced);
    const auto& parameters = traced.result.channels[2].baseline.parameters;
    const auto scale = std::ranges::find(parameters, "scale_factor", &ModelParameter::name);
    ASSERT_NE(scale, parameters.end());
    sum += scale->value;
    variance += scale->std_error * scale->std_error;
  }
  const double std_error = std::sqrt(variance) / kSeeds;
  EXPECT_LT(std_error, 3e-5);
  EXPECT_NEAR(sum / kSeeds, 1.012, 4.0 * std_error);
}

// Turns at 5 to 40 deg/s and back, twice.
Motion SlowAndFastTurns() {
  Motion motion;
  motion.Rest(2.0);
  for (int round = 0; round < 2; ++round) {
    for (const double rate : {5.0, 10.0, 20.0, 40.0}) motion.ThereAndBack(kInnerAxis, 180.0, rate);
  }
  return motion;
}

// In a warm-up T and dT/dt say nearly the same. The noise of a reading is in the output and in the
// turn by the readings; a model that took it for turning would find it in the small difference.
TEST(TraceOfAScaleThatDependsOnTemperatureWhileItWarmsUp, NamesNothingElse) {
  constexpr int kSeeds = 6;
  constexpr double kPerDegC = 2e-4;
  const Motion turns = SlowAndFastTurns();
  const auto rate = [&](double t_s) { return turns.At(t_s).rate_deg_s[kInnerAxis]; };
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    Story story;
    story.seed = seed;
    story.duration_s = turns.duration_s();
    story.gyro_hz = 100.0;
    story.reference_hz = 50.0;
    story.white_deg_s = 0.02;
    story.reading_deg = 0.004;
    story.info.gyro_present = {false, false, true};
    story.rate_deg_s = rate;
    story.angle_deg = [&](double t_s) { return turns.At(t_s).angle_deg[kInnerAxis]; };
    story.temperature_degC = [](double t_s) { return 38.0 - 45.0 * std::exp(-t_s / 60.0); };
    story.spoil_gyro = [&](GyroSample* sample) {
      sample->xi[2] +=
          131.0 * kPerDegC * rate(sample->t_s) * (story.temperature_degC(sample->t_s) - 25.0);
      return true;
    };
    const Traced traced = TraceOf({&story});
    ASSERT_EQ(traced.result.channels.size(), 1u);
    const ChannelTrace& channel = traced.result.channels[0];
    ASSERT_EQ(channel.effects.size(), 1u) << channel.summary;
    ASSERT_EQ(channel.effects[0].id, "scale.temperature");
    EXPECT_THAT(channel.effects[0].rivals, ::testing::IsEmpty());
    const ModelParameter& c = channel.effects[0].parameters[0];
    squares += std::pow((c.value - kPerDegC) / c.std_error, 2.0);
  }
  // Of 6 normal errors: beyond 22.5 in one of 1000.
  EXPECT_LT(squares, 22.5);
}

// An offset of the output is the zero-rate offset's alone, of one power-on or of each.
TEST(TraceOfTwoPowerOns, HasTheSameScaleFactorWhateverTheirZeroRateOffsets) {
  std::vector<double> scales;
  for (const double offset_deg_s : {0.0, 10.0}) {
    Story first, second;
    first.seed = 1;
    second.seed = 2;
    second.duration_s = 100.0;
    first.info.power_on = "1";
    second.info.power_on = "2";
    first.info.source = "1.csv";
    second.info.source = "2.csv";
    second.spoil_gyro = [&](GyroSample* sample) {
      sample->xi[2] += 131.0 * offset_deg_s;
      return true;
    };
    const Traced traced = TraceOf({&first, &second});
    ExpectNoEffect(traced);
    scales.push_back(traced.models.at(2).m_row[2]);
  }
  EXPECT_NEAR(scales[0], scales[1], 1e-9);
}

TEST(TraceOfATableOfOneChannel, GivesThatChannelsNumbersWhicheverItIs) {
  for (std::size_t c = 0; c < 3; ++c) {
    Story story;
    story.info.gyro_present = {false, false, false};
    story.info.gyro_present[c] = true;
    story.UseSensorAngle(static_cast<SensorAxis>(c));
    story.scale = {0.0, 0.0, 0.0};
    story.scale[c] = 0.985;
    const Traced traced = TraceOf({&story});
    ExpectNoEffect(traced);
    ASSERT_EQ(traced.result.channels.size(), 1u);
    EXPECT_EQ(traced.result.channels[0].axis, static_cast<SensorAxis>(c));
    ExpectWithinItsInterval(traced.result.channels[0], "scale_factor", 0.985);
    EXPECT_NEAR(traced.models[0].m_row[c], 0.985, 1e-3);
  }
}

bool SaysOneOf(const std::vector<std::string>& remarks, const std::string& word) {
  return std::ranges::any_of(
      remarks, [&](const std::string& remark) { return remark.find(word) != std::string::npos; });
}

TEST(TraceOfAKnownLatitude, TakesEarthsRotationOffOnlyWhereTheOrientationIsKnown) {
  Story known, unknown;
  known.info.source = "known.csv";
  known.seed = 2;
  unknown.info.source = "unknown.csv";
  known.info.site_latitude_deg = unknown.info.site_latitude_deg = 50.0;
  unknown.UseSensorAngle();
  const Traced sure = TraceOf({&known});
  EXPECT_FALSE(SaysOneOf(sure.result.remarks, "Earth's rotation"));
  const Traced unsure = TraceOf({&unknown});
  EXPECT_TRUE(SaysOneOf(unsure.result.remarks, "not how the sensor is oriented"));
  const Traced mixed = TraceOf({&known, &unknown});
  EXPECT_TRUE(SaysOneOf(mixed.result.remarks, "taken off in known.csv, and not in unknown.csv"));
  const auto& unseen = mixed.result.channels[2].unidentifiable;
  const auto earth = std::ranges::find(unseen, "bias.earth_rate", &calibration::Unidentifiable::id);
  ASSERT_NE(earth, unseen.end());
  EXPECT_THAT(earth->because, HasSubstr("not known all the time"));
}

TEST(TraceOfAConstantColumn, ListsItsEffectsAndHowToShowThem) {
  Story story;
  story.info.covariates = {"supply_v"};
  story.covariates = {[](double) { return 5.0; }};
  const Traced traced = TraceOf({&story});
  for (const ChannelTrace& channel : traced.result.channels) {
    std::vector<std::string> ids;
    for (const auto& effect : channel.unidentifiable) ids.push_back(effect.id);
    EXPECT_THAT(ids, ::testing::IsSupersetOf({"bias.of(supply_v)", "scale.of(supply_v)"}));
  }
}

// A column that acts by its square has a chart of the error against it.
TEST(TraceOfAProduct, DrawsTheErrorAgainstItsFirstFactor) {
  Story story;
  story.info.covariates = {"supply_v"};
  const auto supply = [](double t_s) { return 5.0 + 0.5 * std::sin(t_s * (0.05 + 6e-4 * t_s)); };
  story.covariates = {supply};
  story.spoil_gyro = [=](GyroSample* sample) {
    sample->xi[2] += 131.0 * 0.8 * std::pow(supply(sample->t_s) - 5.0, 2.0);
    return true;
  };
  const Traced traced = TraceOf({&story});
  const ChannelTrace& channel = traced.result.channels[2];
  ASSERT_FALSE(channel.effects.empty()) << channel.summary;
  EXPECT_THAT(channel.effects[0].id, HasSubstr("supply_v"));
  EXPECT_EQ(channel.curves.traced_covariate, "supply_v");
  const calibration::Series& series = channel.curves.rate_error_by_traced_covariate;
  ASSERT_GT(series.x.size(), 10u);
  const auto size = [](const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values) sum += value * value;
    return sum;
  };
  EXPECT_LT(size(series.after), 0.1 * size(series.before));
}

}  // namespace
}  // namespace gyrobench::testing
