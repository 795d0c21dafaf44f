// What one channel finds of the bench is told to the others.
#include "calibration/trace/bench_finding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::testing {
namespace {

using calibration::BenchFinding;
using calibration::BenchFindings;
using calibration::Effect;

constexpr std::size_t kOuter = 0, kMiddle = 1, kInner = 2;

const Effect& EffectOf(std::string_view id) {
  for (const Effect& effect : calibration::EffectCatalogue()) {
    if (effect.id == id) return effect;
  }
  throw std::runtime_error("no such effect");
}

BenchFinding Ripple(std::size_t axis, double periods, double largest_deg) {
  BenchFinding error{&EffectOf("angle.ripple"), axis, {periods}, {}};
  error.largest = largest_deg;
  return error;
}
BenchFinding Backlash(std::size_t axis, double largest_deg) {
  BenchFinding error{&EffectOf("angle.backlash"), axis, {0.0}, {}};
  error.largest = largest_deg;
  return error;
}

TEST(AnErrorOfAnAxisThatOnlyTurnsDirections, IsToldWithItsSize) {
  const BenchFindings own{{}, {kOuter, kMiddle}, {kOuter, kMiddle, kInner}};
  const std::vector<BenchFinding> told = NewTo(own, {Backlash(kInner, 0.03)});
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].table_axis, kInner);
  EXPECT_EQ(told[0].largest, 0.03);
}

// In whichever order they come.
TEST(AnErrorThatTwoChannelsBound, IsOfTheLesserBoundAtMost) {
  const BenchFindings own{{}, {kOuter}, {kOuter, kInner}};
  for (const auto& [first, second] : {std::pair(0.03, 0.01), std::pair(0.01, 0.03)}) {
    const std::vector<BenchFinding> told =
        NewTo(own, {Backlash(kInner, first), Backlash(kInner, second)});
    ASSERT_EQ(told.size(), 1u);
    EXPECT_EQ(told[0].largest, 0.01);
  }
}

// Axes of one make have as many teeth, but not teeth as bad.
TEST(ARippleOfAnotherAxis, IsTriedInAnySize) {
  const BenchFindings own{{}, {kOuter}, {kOuter}};
  const std::vector<BenchFinding> told = NewTo(own, {Ripple(kInner, 360.0, 0.02)});
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].table_axis, kOuter);
  EXPECT_TRUE(std::isinf(told[0].largest));
}

TEST(WhatAChannelHasFoundItself, IsNotToldToIt) {
  const BenchFindings own{{Ripple(kInner, 360.2, 0.02)}, {kInner}, {kInner}};
  EXPECT_TRUE(NewTo(own, {Ripple(kInner, 360.0, 0.02)}).empty());
  EXPECT_EQ(NewTo(own, {Ripple(kInner, 362.0, 0.02)}).size(), 1u);
}

TEST(WhatAChannelWasTold, IsNotItsOwnWord) {
  const std::vector<BenchFinding> told = {Backlash(kMiddle, 0.03)};
  const BenchFindings named{{Backlash(kMiddle, 0.02), Backlash(kInner, 0.02)}, {kInner}, {kInner}};
  const BenchFindings own = Without(named, told);
  ASSERT_EQ(own.found.size(), 1u);
  EXPECT_EQ(own.found[0].table_axis, kInner);
}

BenchFinding Shaking() {
  BenchFinding finding{&EffectOf("bias.vibration"), kInner, {20.0, 2.0}, {}};
  finding.of_stand = true;
  return finding;
}

// By its own rate a channel says that the stand may shake: all try whether any axis does it.
TEST(AStandThatMayShake, IsToldToAllOnce) {
  BenchFindings supposes{{}, {kInner}, {kInner}};
  supposes.supposed = {Shaking()};
  EXPECT_EQ(NewTo(supposes, {Shaking(), Shaking()}).size(), 1u);
}

// Named by the speed of all axes it is the channel's own word from then on.
TEST(AStandThatShakes, StaysNamed) {
  const BenchFindings names{{Shaking()}, {kInner}, {kInner}};
  const BenchFindings own = Without(names, {Shaking()});
  EXPECT_EQ(own.found.size(), 1u);
  EXPECT_TRUE(NewTo(own, own.found).empty());
  EXPECT_FALSE(NamesWhatIsGone(names, {Shaking()}, {}));
}

TEST(WhatAChannelNamesOfAnother, IsGoneWhenTheOtherTakesItBack) {
  const std::vector<BenchFinding> before = {Backlash(kMiddle, 0.03)};
  const BenchFindings names{{Backlash(kMiddle, 0.02)}, {kInner}, {kInner, kMiddle}};
  const BenchFindings names_own{{Backlash(kInner, 0.02)}, {kInner}, {kInner, kMiddle}};
  EXPECT_TRUE(NamesWhatIsGone(names, before, {}));
  EXPECT_FALSE(NamesWhatIsGone(names, before, before));
  EXPECT_FALSE(NamesWhatIsGone(names_own, before, {}));
}

}  // namespace
}  // namespace gyrobench::testing
