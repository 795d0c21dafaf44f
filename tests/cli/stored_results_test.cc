// Results of records that another version wrote.
#include "cli/stored_results.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "calibration/artefact/trace_json.h"
#include "calibration/estimators/result_json.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;

calibration::AnalysisResult SomeResult() {
  calibration::AnalysisResult result;
  result.info.source = "turns.csv";
  result.samples = 4000;
  result.reference_samples = 80;
  result.duration_s = 40.0;
  result.gyro_rate_hz = 100.0;
  result.defects = {{"gap", 2, 8.5, "line 851"}};
  result.remarks = {"a remark of all"};
  calibration::ScaleResult& scale = result.scale.emplace_back();
  scale.axis = SensorAxis::kY;
  scale.unit = "LSB";
  scale.schedule = "stops";
  double value = 0.0;
  for (double* field : {&scale.alpha,
                        &scale.alpha_std_error,
                        &scale.alpha_statistical_std_error,
                        &scale.reference_uncertainty,
                        &scale.scale_error,
                        &scale.bias,
                        &scale.bias_std_error,
                        &scale.bias_temperature_degC,
                        &scale.residual_rms_deg,
                        &scale.whitened_rms,
                        &scale.paper_alpha,
                        &scale.paper_alpha_std_error,
                        &scale.paper_first_rest_alpha,
                        &scale.min_rate_deg_s,
                        &scale.max_rate_deg_s,
                        &scale.min_temperature_degC,
                        &scale.max_temperature_degC,
                        &scale.tick_ratio,
                        &scale.tick_ratio_std_error,
                        &scale.noise.angle_random_walk_deg_sqrt_s,
                        &scale.noise.bias_random_walk_deg_s_sqrt_s,
                        &scale.noise.reference_deg})
    *field = value += 1.25;
  scale.turns = 17;
  scale.remarks = {"a remark of the scale factor"};
  calibration::BiasResult& bias = result.bias.emplace_back();
  bias.axis = SensorAxis::kX;
  bias.unit = "LSB";
  for (double* field : {&bias.reference_temperature_degC, &bias.min_temperature_degC,
                        &bias.max_temperature_degC, &bias.rms_error, &bias.residual_rms,
                        &bias.paper_rms_error, &bias.noise.angle_random_walk_deg_sqrt_s,
                        &bias.noise.bias_random_walk_deg_s_sqrt_s, &bias.noise.reference_deg})
    *field = value += 1.25;
  bias.coefficients = {71.5, 72.5};
  bias.std_errors = {0.25, 0.5};
  bias.paper_coefficients = {73.5, 74.5};
  bias.remarks = {"a remark of the bias"};
  return result;
}

// Every field has a value of its own, so that none is taken for another.
TEST(ReadAnalysis, SaysWhatTheResultSaidThatWasWritten) {
  const calibration::AnalysisResult result = SomeResult();
  const auto text = [](const calibration::AnalysisResult& one) {
    return RenderText(presentation::AnalysisDocument(one), {});
  };
  EXPECT_EQ(text(ReadAnalysis(calibration::ToJson(result))), text(result));
}

// Fields that another version leaves out or has of another kind, and null for what is not known,
// are no reason to fail.
TEST(ReadAnalysis, TakesWhatIsNotThereForNotKnown) {
  EXPECT_TRUE(ReadAnalysis(nullptr).scale.empty());
  const auto result = ReadAnalysis(
      {{"scale", {{{"axis", "x"}, {"alpha", nullptr}, {"turns", "many"}, {"paper", 1.5}}}}});
  ASSERT_EQ(result.scale.size(), 1u);
  EXPECT_EQ(result.scale[0].axis, SensorAxis::kX);
  EXPECT_TRUE(std::isnan(result.scale[0].alpha));
  EXPECT_EQ(result.scale[0].turns, 0);
  EXPECT_TRUE(std::isnan(result.scale[0].paper_alpha));
}

TEST(ReadAnalysis, KeepsTheOtherNumbersOfAListInTheirPlaces) {
  const auto result =
      ReadAnalysis({{"bias", {{{"axis", "z"}, {"coefficients", {nullptr, 2.5, "none"}}}}}});
  ASSERT_EQ(result.bias.size(), 1u);
  const std::vector<double>& coefficients = result.bias[0].coefficients;
  ASSERT_EQ(coefficients.size(), 3u);
  EXPECT_TRUE(std::isnan(coefficients[0]));
  EXPECT_EQ(coefficients[1], 2.5);
  EXPECT_TRUE(std::isnan(coefficients[2]));
}

TEST(ReadTrace, SaysWhatTheTraceSaid) {
  EXPECT_TRUE(ReadTrace(nullptr).result.channels.empty());
  EXPECT_TRUE(ReadTrace(nullptr).not_known.empty());
  calibration::TraceResult trace;
  trace.channels.resize(3);
  trace.channels[0].verdict = calibration::Verdict::kPartlyExplained;
  trace.channels[0].effects.resize(1);
  trace.channels[0].effects[0].id = "angle.latency";
  trace.channels[0].effects[0].rivals = {"angle.clock_drift"};
  trace.channels[1].verdict = calibration::Verdict::kUnexplained;
  trace.channels[1].summary = "Something remains.";
  trace.channels[2].baseline.whitened_rms = 1.0;
  const auto text = [](const calibration::TraceResult& one) {
    return RenderText(presentation::TraceSummary(one), {});
  };
  EXPECT_EQ(text(ReadTrace(calibration::ToJson(trace)).result), text(trace));
}

// What a later version wrote is not taken for the first that this one knows.
json LaterTrace() {
  calibration::TraceResult trace;
  trace.channels.resize(2);
  for (auto& channel : trace.channels) channel.baseline.whitened_rms = 1.0;
  trace.channels[1].axis = SensorAxis::kX;
  return calibration::ToJson(trace);
}

TEST(ReadTrace, SaysWhichVerdictOrAxisItDoesNotKnowAndInventsNone) {
  for (const auto& [key, value, known] :
       {std::tuple("verdict", "contradicted",
                   "none, explained, partly_explained, unexplained, cannot_be"),
        std::tuple("gyro", "w", "x, y, z")}) {
    json later = LaterTrace();
    later["channels"][0][key] = value;
    const StoredTrace trace = ReadTrace(later);
    ASSERT_EQ(trace.result.channels.size(), 1u);
    EXPECT_EQ(trace.result.channels[0].axis, SensorAxis::kX);
    EXPECT_THAT(trace.not_known,
                testing::ElementsAre(fmt::format("trace.channels[0].{} is \"{}\", and this version "
                                                 "knows {}: nothing is said of that axis here",
                                                 key, value, known)));
    EXPECT_THAT(RenderText(presentation::TraceSummary(trace.result, trace.not_known), {}),
                testing::HasSubstr(value));
  }
  json without = LaterTrace();
  without["channels"][0].erase("verdict");
  EXPECT_THAT(ReadTrace(without).not_known,
              testing::ElementsAre(testing::HasSubstr("trace.channels[0].verdict is not there")));
}

calibration::TraceResult WithTwoEffects() {
  calibration::TraceResult trace;
  calibration::ChannelTrace& channel = trace.channels.emplace_back();
  channel.baseline.whitened_rms = 1.0;
  channel.effects.resize(2);
  channel.effects[0].id = "angle.ripple";
  channel.effects[0].owner = calibration::EffectOwner::kReference;
  channel.effects[1].id = "scale.cubic";
  return trace;
}

// Whose an effect is, where it is from and what it was chosen on are told like an axis is.
TEST(ReadTrace, LeavesOutAnEffectOfWhichItDoesNotKnowANameAndTellsEach) {
  json later = calibration::ToJson(WithTwoEffects());
  json& effect = later["channels"][0]["effects"][1];
  effect["origin"] = "guessed";
  effect["owner"] = "air";
  effect.erase("chosen_on");
  const StoredTrace trace = ReadTrace(later);
  const auto& effects = trace.result.channels.at(0).effects;
  ASSERT_EQ(effects.size(), 1u);
  EXPECT_EQ(effects[0].id, "angle.ripple");
  EXPECT_EQ(effects[0].owner, calibration::EffectOwner::kReference);
  const std::string place = "trace.channels[0].effects[1].";
  const std::string consequence = ": nothing is said of that effect (scale.cubic) here";
  EXPECT_THAT(
      trace.not_known,
      testing::ElementsAre(place +
                               "origin is \"guessed\", and this version knows catalogue, "
                               "composed, empirical" +
                               consequence,
                           place +
                               "owner is \"air\", and this version knows gyro, reference, "
                               "bench" +
                               consequence,
                           place +
                               "chosen_on is not there, and this version knows training_part, "
                               "all_data" +
                               consequence));
}

TEST(ReadTrace, TellsAllNamesOfAnAxisThatItDoesNotKnow) {
  json later = LaterTrace();
  later["channels"][0]["gyro"] = "w";
  later["channels"][0]["verdict"] = "contradicted";
  const StoredTrace trace = ReadTrace(later);
  EXPECT_EQ(trace.result.channels.size(), 1u);
  EXPECT_THAT(trace.not_known, testing::ElementsAre(testing::HasSubstr("[0].gyro is \"w\""),
                                                    testing::HasSubstr("[0].verdict is")));
}

TEST(ReadTrace, CallsNoAxisUntracedOfWhichTheTraceDoesNotSay) {
  json without = LaterTrace();
  without["channels"][0].erase("baseline");
  const StoredTrace trace = ReadTrace(without);
  EXPECT_EQ(trace.result.channels.size(), 1u);
  EXPECT_THAT(trace.not_known,
              testing::ElementsAre(testing::HasSubstr("trace.channels[0].baseline is not there")));
  without["channels"][0]["verdict"] = "unexplained";  // of an axis that was traced
  EXPECT_EQ(ReadTrace(without).result.channels.size(), 2u);
}

TEST(ReadAnalysis, TellsEveryNameOfTheMeasurementThatItDoesNotKnow) {
  json later = calibration::ToJson(SomeResult());
  later["info"]["gyro_unit"] = "rev_min";
  later["info"].erase("reference");
  EXPECT_THAT(
      ReadAnalysis(later).remarks,
      testing::IsSupersetOf(
          {testing::HasSubstr("result.info.gyro_unit is \"rev_min\", and this version knows "
                              "lsb, deg_s, rad_s: it is not known here"),
           testing::HasSubstr("result.info.reference is not there")}));
}

TEST(ReadAnalysis, SaysWhichAxisItDoesNotKnow) {
  json later = calibration::ToJson(SomeResult());
  later["scale"][0]["axis"] = "w";
  const auto result = ReadAnalysis(later);
  EXPECT_TRUE(result.scale.empty());
  EXPECT_THAT(result.remarks, testing::Contains(testing::HasSubstr(
                                  "result.scale[0].axis is \"w\", and this version "
                                  "knows x, y, z")));
}

}  // namespace
}  // namespace gyrobench::cli
