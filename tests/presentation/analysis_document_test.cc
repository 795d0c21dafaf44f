// What an analysis says beside a trace of the same run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "tests/presentation/sample_content.h"
#include "tests/words.h"

namespace gyrobench::presentation {
namespace {

using calibration::AnalysisResult;
using testing::HasSubstr;
using testing::Not;

calibration::ChannelTrace Traced(SensorAxis axis, const std::vector<std::string>& ids) {
  calibration::ChannelTrace channel;
  channel.axis = axis;
  for (const std::string& id : ids) channel.effects.emplace_back().id = id;
  return channel;
}

// A scale factor beside which a nonlinearity is named is none that holds elsewhere.
TEST(WithTraceRemarks, SaysOfWhichNumbersTheTraceNamesEffects) {
  AnalysisResult result;
  result.scale.resize(1);
  result.scale[0].axis = SensorAxis::kZ;
  result.bias.resize(2);
  result.bias[0].axis = SensorAxis::kX;
  result.bias[1].axis = SensorAxis::kZ;
  for (auto& bias : result.bias) bias.coefficients = {-132.0};
  calibration::TraceResult trace;
  trace.channels = {Traced(SensorAxis::kX, {"bias.g_linear", "angle.latency"}),
                    Traced(SensorAxis::kZ, {"scale.cubic", "scale.cubic"})};
  const std::string text = RenderText(AnalysisDocument(WithTraceRemarks(result, trace)), {});
  EXPECT_EQ(Count(text, "the trace names"), 2);
  EXPECT_THAT(text, HasSubstr("the trace names scale.cubic: alpha holds for the rates"));
  EXPECT_THAT(text, HasSubstr("x: the trace names bias.g_linear: this bias is the mean"));
  EXPECT_EQ(RenderText(AnalysisDocument(WithTraceRemarks(result, {})), {}),
            RenderText(AnalysisDocument(result), {}));
}

// Two fits of one run have a noise each.
TEST(AnalysisDocument, SaysWhichFitANoiseIsOf) {
  AnalysisResult result = *AnalysisSample().analysis;
  result.scale[0].noise = {0.00341, 1.47e-4, kMissing};
  result.bias[0].noise = {0.00354, 1.04e-4, kMissing};
  const std::string text = Flat(RenderText(AnalysisDocument(result), {}));
  EXPECT_THAT(text,
              HasSubstr("angle random walk 0.00341 deg/sqrt(s) of turns and rests, by this fit"));
  EXPECT_THAT(text, HasSubstr("angle random walk, at rest 0.00354 deg/sqrt(s)"));
}

// The offset of turns and rests and that of the rests alone are compared at one temperature.
TEST(AnalysisDocument, SaysWhichDataABiasIsOf) {
  AnalysisResult result = *AnalysisSample().analysis;
  calibration::BiasResult& bias = result.bias.front();
  calibration::ScaleResult& scale = result.scale.front();
  bias.axis = scale.axis;
  scale.bias = -89.9;
  scale.bias_std_error = 0.1;
  scale.bias_temperature_degC = 29.5;
  bias.reference_temperature_degC = 29.0;
  bias.coefficients = {-85.0, -10.0};
  bias.covariance = {{0.04, 0.0}, {0.0, 0.0}};
  std::string text = Flat(RenderText(AnalysisDocument(result), {}));
  EXPECT_THAT(text, HasSubstr("LSB mean of turns and rests, at 29.50 degC"));
  EXPECT_THAT(text, HasSubstr("by the rests alone -90.00 ± 0.20 LSB beta(T) below"));
  scale.noise = {0.0035, 1e-4, kMissing};
  scale.noise_of_rests = true;
  bias.offset_scatter = 3.3;
  text = Flat(RenderText(AnalysisDocument(result), {}));
  EXPECT_THAT(text, HasSubstr("angle random walk 0.0035 deg/sqrt(s) of the rests alone"));
  EXPECT_THAT(text, HasSubstr("offset, rest to rest 3.3"));
}

TEST(AnalysisDocument, DrawsTheBiasWhereItWasWhatTheRunMeasured) {
  AnalysisResult result = *AnalysisSample().analysis;
  EXPECT_THAT(RenderText(AnalysisDocument(result), {}), Not(HasSubstr("beta z [LSB]")));
  result.scale.clear();
  EXPECT_THAT(RenderText(AnalysisDocument(result), {}), HasSubstr("beta z [LSB]"));
  result.bias[0].coefficients[1] = kMissing;  // a curve that is not known in full is not drawn
  EXPECT_THAT(RenderText(AnalysisDocument(result), {}), Not(HasSubstr("beta z [LSB]")));
}

}  // namespace
}  // namespace gyrobench::presentation
