// What one channel finds of an axis's readings is told to the others.
#include "calibration/trace/angle_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace gyrobench::testing {
namespace {

using calibration::AngleError;
using calibration::AngleErrors;
using calibration::Effect;

constexpr std::size_t kOuter = 0, kMiddle = 1, kInner = 2;

const Effect& EffectOf(std::string_view id) {
  for (const Effect& effect : calibration::EffectCatalogue()) {
    if (effect.id == id) return effect;
  }
  throw std::runtime_error("no such effect");
}

AngleError Ripple(std::size_t axis, double periods, double largest_deg) {
  AngleError error{&EffectOf("angle.ripple"), axis, {periods}, {}};
  error.largest = largest_deg;
  return error;
}
AngleError Backlash(std::size_t axis, double largest_deg) {
  AngleError error{&EffectOf("angle.backlash"), axis, {0.0}, {}};
  error.largest = largest_deg;
  return error;
}

TEST(AnErrorOfAnAxisThatOnlyTurnsDirections, IsToldWithItsSize) {
  const AngleErrors own{{}, {kOuter, kMiddle}, {kOuter, kMiddle, kInner}};
  const std::vector<AngleError> told = NewTo(own, {Backlash(kInner, 0.03)});
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].table_axis, kInner);
  EXPECT_EQ(told[0].largest, 0.03);
}

// Axes of one make have as many teeth, but not teeth as bad.
TEST(ARippleOfAnotherAxis, IsTriedInAnySize) {
  const AngleErrors own{{}, {kOuter}, {kOuter}};
  const std::vector<AngleError> told = NewTo(own, {Ripple(kInner, 360.0, 0.02)});
  ASSERT_EQ(told.size(), 1u);
  EXPECT_EQ(told[0].table_axis, kOuter);
  EXPECT_TRUE(std::isinf(told[0].largest));
}

TEST(WhatAChannelHasFoundItself, IsNotToldToIt) {
  const AngleErrors own{{Ripple(kInner, 360.2, 0.02)}, {kInner}, {kInner}};
  EXPECT_TRUE(NewTo(own, {Ripple(kInner, 360.0, 0.02)}).empty());
  EXPECT_EQ(NewTo(own, {Ripple(kInner, 362.0, 0.02)}).size(), 1u);
}

TEST(WhatAChannelWasTold, IsNotItsOwnWord) {
  const std::vector<AngleError> told = {Backlash(kMiddle, 0.03)};
  const AngleErrors named{{Backlash(kMiddle, 0.02), Backlash(kInner, 0.02)}, {kInner}, {kInner}};
  const AngleErrors own = Without(named, told);
  ASSERT_EQ(own.found.size(), 1u);
  EXPECT_EQ(own.found[0].table_axis, kInner);
}

TEST(WhatAChannelNamesOfAnother, IsGoneWhenTheOtherTakesItBack) {
  const std::vector<AngleError> before = {Backlash(kMiddle, 0.03)};
  const AngleErrors names{{Backlash(kMiddle, 0.02)}, {kInner}, {kInner, kMiddle}};
  const AngleErrors names_own{{Backlash(kInner, 0.02)}, {kInner}, {kInner, kMiddle}};
  EXPECT_TRUE(NamesWhatIsGone(names, before, {}));
  EXPECT_FALSE(NamesWhatIsGone(names, before, before));
  EXPECT_FALSE(NamesWhatIsGone(names_own, before, {}));
}

}  // namespace
}  // namespace gyrobench::testing
