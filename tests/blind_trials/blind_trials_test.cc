// A slice of the blind trials: laws so loose that a sound tracer fails them by bad luck once in
// many thousands of seeds.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/blind_trials/bound.h"
#include "tests/blind_trials/campaign.h"

namespace gyrobench::blind_trials {
namespace {

CampaignOptions Slice(int sets) {
  CampaignOptions options;
  options.sets = options.silent_sets = sets;
  options.seed = 20240131;
  return options;
}
std::vector<Outcome> RunAll(const std::vector<TrialSpec>& specs) {
  return RunTrials(specs, 1, [](std::size_t) {});
}

// At a false discovery of 1 %, two or more of six sets: one in 700 campaigns.
TEST(BlindTrials, ARecordingWithoutAnythingHiddenGetsNoName) {
  int named = 0;
  for (const Outcome& outcome : RunAll(PlanTrials("silent", Slice(6)))) {
    EXPECT_EQ(outcome.failure, "");
    named += outcome.winners.empty() ? 0 : 1;
  }
  EXPECT_LE(named, 1);
}

// Exact in 98.5 %: three or more of eight missed, one in 5000 campaigns.
TEST(BlindTrials, AStrongEffectIsNamedAndItsParametersAreNear) {
  CampaignOptions options = Slice(1);
  options.levels = {kHigh};
  options.effects = {
      "bias.g_linear",        "scale.temperature", "scale.asymmetry",       "angle.latency",
      "angle.eccentricity_1", "angle.backlash",    "bias.temperature_rate", "scale.g"};
  int exact = 0, wrong = 0;
  for (const Outcome& outcome : RunAll(PlanTrials("single", options))) {
    EXPECT_EQ(outcome.failure, "");
    wrong += outcome.WrongName() ? 1 : 0;
    if (!outcome.Exact()) continue;
    ++exact;
    for (const auto& error : outcome.errors) {
      EXPECT_NEAR(error.estimate, error.truth, 5 * error.std_error)
          << error.id << " " << error.name;
    }
  }
  EXPECT_GE(exact, 6);
  EXPECT_LE(wrong, 1);
}

// Flicker leaves structure beside a tone of a hundred standard deviations, and windows of the angle
// that are larger by chance.
TEST(BlindTrials, AToneThatExplainsNearlyAllIsNamedBesideFlicker) {
  const Outcome outcome =
      RunTrial({.seed = 10490195383755709180U, .effects = {{"bias.tone", kHigh}}});
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.truth.noise, NoiseKind::kFlicker);
  EXPECT_TRUE(outcome.Exact());
}

TEST(BlindTrials, WhatIsInNoCatalogueIsNotTakenForSomethingElse) {
  CampaignOptions options = Slice(1);
  options.levels = {kHigh};
  options.effects = {"supply_bias", "flat_stretch", "supply_gravity"};
  int recognised = 0;
  for (const Outcome& outcome : RunAll(PlanTrials("unknown", options))) {
    const Recognition how = Recognise(outcome);
    recognised += how != Recognition::kNone && how != Recognition::kFalseName ? 1 : 0;
  }
  EXPECT_GE(recognised, 2);
}

// A name of the catalogue is its own copy; a product of gravity and a slow wave are nothing that
// the two names say; a g-sensitivity that hardly changes with temperature is one that does not.
TEST(Bound, SaysWhatDoesTheSameAsWhatIsHidden) {
  using ::testing::ElementsAre;
  const auto copies = [](const char* id, Level level) {
    return CopiesAtBound({.seed = 12, .effects = {{id, level}}});
  };
  EXPECT_THAT(copies("bias.g_linear", kMid), ElementsAre("bias.g_linear"));
  EXPECT_THAT(copies("bias.step", kHigh), ElementsAre("bias.step"));
  EXPECT_THAT(copies("gravity_product", kHigh), ElementsAre());
  EXPECT_THAT(copies("slow_tone", kHigh), ElementsAre());
  EXPECT_THAT(copies("g_temperature", kLow), ElementsAre("bias.g_linear"));
}

TEST(BlindTrials, ASequenceOfOneSpeedAndOneWayCannotSeeTheAsymmetryAndSaysSo) {
  const Outcome outcome = RunTrial({.seed = 99, .sequence = SequenceKind::kOneWay});
  EXPECT_EQ(outcome.failure, "");
  EXPECT_NE(
      std::find(outcome.unidentifiable.begin(), outcome.unidentifiable.end(), "scale.asymmetry"),
      outcome.unidentifiable.end());
}

// No plan may tell by its seed what is hidden: the seeds of two plans differ in nothing but order.
TEST(BlindTrials, SeedsDoNotDependOnWhatIsHidden) {
  CampaignOptions one = Slice(5), other = one;
  one.effects = {"scale.g"};
  other.effects = {"angle.backlash"};
  const auto a = PlanTrials("single", one), b = PlanTrials("single", other);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].seed, b[i].seed);
}

}  // namespace
}  // namespace gyrobench::blind_trials
