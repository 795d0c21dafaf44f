// The Earth turns by 0.0042 deg/s, and nobody said where the stand is: that must not be sold as a
// sensitivity of the gyro to gravity.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calibration/signal/collector.h"
#include "calibration/trace/trace.h"
#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {
namespace {

using calibration::ChannelTrace;
using calibration::ModelParameter;
using calibration::TracedEffect;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kEarth = "bias.earth_rate";
constexpr const char* kSays = "The site's latitude is needed";

ChannelTrace TraceOf(const TrialSpec& spec) {
  calibration::Collector collector;
  RecordTrial(spec, collector);
  const calibration::Recording recording = collector.Take();
  const calibration::Recording* const recordings[] = {&recording};
  calibration::TraceOptions options;
  options.curves = false;
  return calibration::Trace(recordings, options).result.channels.at(0);
}

// One without a value where the channel does not name the effect.
ModelParameter Parameter(const ChannelTrace& channel, const std::string& id,
                         const std::string& name) {
  const auto effect = std::ranges::find(channel.effects, id, &TracedEffect::id);
  if (effect == channel.effects.end()) return {};
  return *std::ranges::find(effect->parameters, name, &ModelParameter::name);
}

bool MayBeEarth(const TracedEffect& effect) {
  return effect.id == kEarth || std::ranges::find(effect.rivals, kEarth) != effect.rivals.end();
}

class UnknownLatitude : public ::testing::TestWithParam<SequenceKind> {};

// Its vertical part alone is ten standard errors or more in each of these sequences.
TEST_P(UnknownLatitude, IsAskedForWhereverTheEarthTurns) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const ChannelTrace z =
        TraceOf({.seed = 4100 + seed, .sequence = GetParam(), .latitude_known = false});
    EXPECT_TRUE(std::ranges::any_of(z.effects, MayBeEarth)) << seed << ": " << z.summary;
    EXPECT_THAT(z.summary, HasSubstr(kSays)) << seed;
    for (const TracedEffect& effect : z.effects) {
      if (effect.id != "bias.g_linear") continue;
      EXPECT_THAT(effect.settled_by, HasSubstr("latitude")) << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sequences, UnknownLatitude,
                         ::testing::Values(SequenceKind::kFull, SequenceKind::kUpAndDown,
                                           SequenceKind::kSixPoses));

TEST(SensitivityToGravity, IsCertainWhereItIsLargerThanTheEarthsRotation) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const ChannelTrace z = TraceOf(
        {.seed = 4200 + seed, .effects = {{"bias.g_linear", kHigh}}, .latitude_known = false});
    const auto named = std::ranges::find(z.effects, "bias.g_linear", &TracedEffect::id);
    ASSERT_NE(named, z.effects.end()) << seed << ": " << z.summary;
    EXPECT_FALSE(MayBeEarth(*named)) << seed;
  }
}

// The vertical part is one with k_z of channel z, whatever the poses.
TEST(SensitivityToGravity, CountsTheEarthsRotationAmongItsErrors) {
  constexpr double kEarth_deg_s = 360.0 / 86164.1;
  TrialSpec spec = {.seed = 4203, .effects = {{"bias.g_linear", kHigh}}, .latitude_known = false};
  const ModelParameter unknown = Parameter(TraceOf(spec), "bias.g_linear", "k_z");
  spec.latitude_known = true;
  const ModelParameter known = Parameter(TraceOf(spec), "bias.g_linear", "k_z");
  EXPECT_TRUE(std::isnan(known.statistical_std_error));
  EXPECT_NEAR(unknown.statistical_std_error, known.std_error, 0.02 * known.std_error);
  EXPECT_NEAR(unknown.std_error,
              std::hypot(unknown.statistical_std_error, kEarth_deg_s / std::sqrt(3.0)), 3e-5);
  EXPECT_GT(std::fabs(unknown.value - known.value), 3.0 * unknown.statistical_std_error);
  EXPECT_LT(std::fabs(unknown.value - known.value), 2.0 * unknown.std_error);
}

TEST(KnownLatitude, LeavesNothingOfTheEarth) {
  for (const SequenceKind kind : {SequenceKind::kUpAndDown, SequenceKind::kSixPoses}) {
    const ChannelTrace z = TraceOf({.seed = 4301, .sequence = kind});
    EXPECT_THAT(z.summary, Not(HasSubstr(kSays)));
    EXPECT_TRUE(std::ranges::none_of(z.effects, MayBeEarth)) << z.summary;
  }
}

}  // namespace
}  // namespace gyrobench::blind_trials
