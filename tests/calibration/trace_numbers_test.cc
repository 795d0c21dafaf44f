// Numbers of the baseline for sensors that are mounted and built in unusual ways, against what was
// put into the measurement.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibration/trace/trace.h"
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
