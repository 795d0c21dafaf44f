#include "kinematics/find_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "base/error.h"
#include "tests/kinematics/turns.h"

namespace gyrobench::kinematics {
namespace {

using ::testing::HasSubstr;

using Ranges = std::array<AxisRange, 3>;
constexpr Vector3 kX = {1, 0, 0}, kY = {0, 1, 0}, kZ = {0, 0, 1}, kDown = {0, 0, -1};
constexpr AxisRange kFree = {true, 0.0, -3600.0, 3600.0}, kMissing = {};
constexpr Ranges kAllFree = {kFree, kFree, kFree};

// A pose this near to a direction may be taken where it saves motion.
constexpr double kNearEnough_deg = 0.0101;

double Angle_deg(const Vector3& a, const Vector3& b) {
  const Vector3 c = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                     a[0] * b[1] - a[1] * b[0]};
  return std::atan2(std::hypot(c[0], c[1], c[2]), a[0] * b[0] + a[1] * b[1] + a[2] * b[2]) * 180 /
         std::numbers::pi;
}

// Limits of a stand's axes, drawn, with an angle within them.
AxisRange DrawRange(Draws& draw) {
  const double middle_deg = draw.Within(90), half_deg = 20 + std::abs(draw.Within(200));
  return {true, middle_deg + draw.Within(half_deg), middle_deg - half_deg, middle_deg + half_deg};
}

void ExpectWithinLimits(const Pose& pose, const Ranges& axes) {
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GE(pose.angles_deg[i], axes[i].min_deg);
    EXPECT_LE(pose.angles_deg[i], axes[i].max_deg);
  }
}

// Angles that some stand can take, drawn.
Vector3 DrawAngles(Draws& draw, const Ranges& axes) {
  Vector3 angles_deg = {};
  for (std::size_t i = 0; i < 3; ++i) {
    const double half_deg = 0.5 * (axes[i].max_deg - axes[i].min_deg);
    angles_deg[i] = axes[i].min_deg + half_deg + draw.Within(half_deg);
  }
  return angles_deg;
}

// Which of the axes there are: all, then with one or two of them missing.
class StandsOf : public ::testing::TestWithParam<int> {
 protected:
  Ranges DrawRanges(Draws& draw) const {
    Ranges axes = {};
    for (int i = 0; i < 3; ++i) {
      if ((GetParam() >> i) % 2 == 0) axes[static_cast<std::size_t>(i)] = DrawRange(draw);
    }
    return axes;
  }
};

// What a stand does at some angles within its limits is found again, if not at the same angles.
TEST_P(StandsOf, UpIsFoundWheneverThereIsAPose) {
  Draws draw(10);
  for (int trial = 0; trial < 300; ++trial) {
    const StandGeometry geometry = draw.Geometry(180, 2);
    const Ranges axes = DrawRanges(draw);
    const Vector3 up = Product(geometry, DrawAngles(draw, axes))[2];
    const PoseAnswer answer = FindPose(geometry, axes, {.up = up});
    ASSERT_TRUE(answer.pose) << answer.reason;
    ExpectWithinLimits(*answer.pose, axes);
    EXPECT_LT(Angle_deg(Product(geometry, answer.pose->angles_deg)[2], up), kNearEnough_deg);
  }
}

TEST_P(StandsOf, AnOrientationIsHeldWheneverThereIsAPose) {
  Draws draw(11);
  for (int trial = 0; trial < 300; ++trial) {
    const StandGeometry geometry = draw.Geometry(180, 2);
    const Ranges axes = DrawRanges(draw);
    const Matrix3 r = Product(geometry, DrawAngles(draw, axes));
    const PoseAnswer answer = FindPose(geometry, axes, {.up = r[2], .forward = r[0]});
    ASSERT_TRUE(answer.pose) << answer.reason;
    ExpectWithinLimits(*answer.pose, axes);
    const Matrix3 held = Product(geometry, answer.pose->angles_deg);
    for (std::size_t row = 0; row < 3; ++row)
      EXPECT_LT(Angle_deg(held[row], r[row]), kNearEnough_deg);
  }
}

TEST_P(StandsOf, TheAxisThatTurnsAboutADirectionIsFoundWheneverThereIsOne) {
  Draws draw(12);
  for (int trial = 0; trial < 300; ++trial) {
    const StandGeometry geometry = draw.Geometry(180, 2);
    const Ranges axes = DrawRanges(draw);
    const auto index = static_cast<std::size_t>(trial % 3);
    if (!axes[index].present) continue;
    Vector3 rates_deg_s = {};
    rates_deg_s[index] = trial % 2 == 0 ? 1.0 : -1.0;
    const Vector3 about = NumericRate(geometry, DrawAngles(draw, axes), rates_deg_s);
    const PoseAnswer answer =
        FindPose(geometry, axes, {.about = about, .axis = static_cast<StandAxis>(index)});
    ASSERT_TRUE(answer.pose) << answer.reason;
    ExpectWithinLimits(*answer.pose, axes);
    rates_deg_s[index] = answer.pose->sense;
    const Vector3 rate = NumericRate(geometry, answer.pose->angles_deg, rates_deg_s);
    EXPECT_LT(Angle_deg(rate, about), kNearEnough_deg);
  }
}

INSTANTIATE_TEST_SUITE_P(FindPose, StandsOf, ::testing::Range(0, 7));

TEST(FindPose, TurnsAboutADirectionWithAnotherOneUp) {
  struct Case {
    Vector3 about, up;
    StandAxis axis;
  };
  const std::vector<Case> cases = {{kZ, kX, StandAxis::kInner}, {kZ, kY, StandAxis::kInner},
                                   {kX, kX, StandAxis::kOuter}, {kX, kZ, StandAxis::kMiddle},
                                   {kY, kY, StandAxis::kOuter}, {kY, kDown, StandAxis::kMiddle}};
  for (const auto& [about, up, axis] : cases) {
    const PoseAnswer answer = FindPose({}, kAllFree, {.up = up, .about = about});
    ASSERT_TRUE(answer.pose) << answer.reason;
    EXPECT_EQ(answer.pose->axis, axis);
    Vector3 rates_deg_s = {};
    rates_deg_s[static_cast<std::size_t>(axis)] = answer.pose->sense;
    EXPECT_LT(Angle_deg(NumericRate({}, answer.pose->angles_deg, rates_deg_s), about), 1e-5);
    EXPECT_LT(Angle_deg(Product({}, answer.pose->angles_deg)[2], up), 1e-6);
  }
}

TEST(FindPose, DoesNotMoveWhereItStandsWell) {
  Ranges axes = kAllFree;
  axes[0].angle_deg = 33;
  axes[1].angle_deg = 90;
  axes[2].angle_deg = -270;
  const PoseAnswer answer = FindPose({}, axes, {.up = kX});
  ASSERT_TRUE(answer.pose);
  EXPECT_NEAR(answer.pose->angles_deg[0], 33, 1e-9);
  EXPECT_NEAR(answer.pose->angles_deg[1], 90, 1e-9);
  EXPECT_NEAR(answer.pose->angles_deg[2], -270, 1e-9);
}

// The dry run plans with exact angles, the run reads them from a sensor.
TEST(FindPose, TheNoiseOfAReadingDoesNotDecideBetweenTwoWays) {
  Draws draw(13);
  for (const PoseRequest& request :
       {PoseRequest{.up = kX}, PoseRequest{.up = kDown}, PoseRequest{.up = kDown, .forward = kX},
        PoseRequest{.up = kY, .about = kY}, PoseRequest{.about = kX}}) {
    const PoseAnswer exact = FindPose({}, kAllFree, request);
    ASSERT_TRUE(exact.pose);
    for (int i = 0; i < 20; ++i) {
      Ranges axes = kAllFree;
      for (AxisRange& axis : axes) axis.angle_deg = draw.Within(0.1);
      const PoseAnswer noisy = FindPose({}, axes, request);
      ASSERT_TRUE(noisy.pose);
      for (std::size_t k = 0; k < 3; ++k)
        EXPECT_NEAR(noisy.pose->angles_deg[k], exact.pose->angles_deg[k], 0.2);
    }
  }
}

std::string ReasonOf(const Ranges& axes, const PoseRequest& request) {
  const PoseAnswer answer = FindPose({}, axes, request);
  EXPECT_FALSE(answer.pose);
  return answer.reason;
}

TEST(FindPose, SaysWhichLimitIsInTheWay) {
  const Ranges axes = {kFree, {true, 0.0, -80.0, 90.0}, kFree};
  EXPECT_THAT(ReasonOf(axes, {.up = kDown}),
              HasSubstr("axis.middle would stand at 180.0 deg, beyond its limits -80 .. 90 deg"));
}

TEST(FindPose, SaysWhichAxisIsMissing) {
  const Ranges one_axis = {kMissing, kMissing, kFree};
  EXPECT_TRUE(FindPose({}, one_axis, {.up = kZ, .about = kZ}).pose);
  EXPECT_EQ(ReasonOf(one_axis, {.up = kX}),
            "the nearest pose is 90.0 deg off; the stand has no outer and no middle axis");
  EXPECT_EQ(ReasonOf(one_axis, {.about = kZ, .axis = StandAxis::kOuter}),
            "this stand has no outer axis");
  const Ranges no_outer = {kMissing, kFree, kFree};
  EXPECT_EQ(FindPose({}, no_outer, {.about = kX}).pose->axis, StandAxis::kMiddle);
  EXPECT_THAT(ReasonOf(no_outer, {.up = kX, .about = kX}), HasSubstr("no outer axis"));
}

TEST(FindPose, GimbalLockIsSaid) {
  EXPECT_TRUE(FindPose({}, kAllFree, {.up = kZ}).pose->gimbal_lock);
  EXPECT_TRUE(FindPose({}, kAllFree, {.up = kDown}).pose->gimbal_lock);
  EXPECT_FALSE(FindPose({}, kAllFree, {.up = kX}).pose->gimbal_lock);
  EXPECT_THAT(ReasonOf({kFree, kFree, kMissing}, {.up = kZ, .about = kY}),
              HasSubstr("parallel there (gimbal lock)"));
}

TEST(FindPose, ASmallLeanDoesNotHinderAStandThatCannotCorrectIt) {
  const StandGeometry geometry = {.mount_deg = {0.2, 0.1, 0.0}, .middle_inner_deg = 0.1};
  const PoseAnswer answer =
      FindPose(geometry, {kMissing, kMissing, kFree}, {.up = kZ, .about = kZ});
  ASSERT_TRUE(answer.pose) << answer.reason;
  EXPECT_GT(answer.pose->off_deg, 0.1);
  EXPECT_LT(answer.pose->off_deg, 0.5);
}

TEST(FindPose, RefusesWhatContradictsItselfOrIsNoNumber) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Ranges lost = kAllFree;
  lost[1].angle_deg = nan;
  const StandGeometry bent = {.outer_middle_deg = nan};
  const std::vector<PoseRequest> requests = {
      {},
      {.forward = kX},
      {.up = kZ, .forward = Vector3{0.1, 0, 1}},
      {.up = kZ, .forward = kX, .about = kZ},
      {.up = kZ, .axis = StandAxis::kInner},
      {.up = Vector3{0, 0, 0}},
      {.up = Vector3{nan, 0, 1}},
  };
  for (const PoseRequest& request : requests) EXPECT_THROW(FindPose({}, kAllFree, request), Error);
  EXPECT_THROW(FindPose({}, lost, {.up = kZ}), Error);
  EXPECT_THROW(FindPose(bent, kAllFree, {.up = kZ}), Error);
}

}  // namespace
}  // namespace gyrobench::kinematics
