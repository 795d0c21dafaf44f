// Readings of the reference that cannot be true.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "calibration/signal/reference_track.h"

namespace gyrobench::testing {
namespace {

using calibration::ReferenceTrack;

constexpr double kReadingInterval_s = 0.02;

std::int64_t Count(const ReferenceTrack& track, const std::string& kind) {
  std::int64_t count = 0;
  for (const Defect& defect : track.defects().defects()) {
    count += defect.kind == kind ? defect.count : 0;
  }
  return count;
}

MeasurementInfo Info(ReferenceKind kind) {
  MeasurementInfo info;
  info.reference = kind;
  info.reference_axis = SensorAxis::kZ;
  info.stand_axis_present = {false, false, true};
  return info;
}

std::array<double, 4> AboutZ(double angle_deg) {
  const double half_rad = 0.5 * angle_deg * std::numbers::pi / 180.0;
  return {std::cos(half_rad), 0.0, 0.0, std::sin(half_rad)};
}

// Turns at 40 deg/s; `angle` may spoil a reading.
template <typename Angle>
void Feed(ReferenceTrack& track, ReferenceKind kind, const Angle& angle) {
  track.Start(Info(kind));
  for (int i = 0; i < 200; ++i) {
    const double t_s = 100.0 + kReadingInterval_s * i;
    const double angle_deg = angle(i, 40.0 * kReadingInterval_s * i);
    if (kind == ReferenceKind::kOrientation) {
      track.Add(OrientationSample{t_s, AboutZ(angle_deg)});
    } else {
      track.Add(AngleSample{t_s, 2, angle_deg});
    }
  }
}

class WildReadings : public ::testing::TestWithParam<ReferenceKind> {};

TEST_P(WildReadings, LeaveTheRotationAsItWas) {
  ReferenceTrack clean, spoilt;
  Feed(clean, GetParam(), [](int, double angle) { return angle; });
  Feed(spoilt, GetParam(),
       [](int i, double angle) { return i == 50 || i == 120 || i == 122 ? angle + 170.0 : angle; });
  EXPECT_EQ(Count(clean, "reference_outlier"), 0);
  EXPECT_EQ(Count(spoilt, "reference_outlier"), 3);
  EXPECT_EQ(Count(spoilt, "reference_jump"), 0);
  EXPECT_NEAR(spoilt.rotation_deg()[2], clean.rotation_deg()[2], 1e-9);
}

TEST_P(WildReadings, ThatPersistAreAJumpAcrossWhichNothingTurned) {
  ReferenceTrack track;
  Feed(track, GetParam(), [](int i, double angle) { return i >= 100 ? angle - 150.0 : angle; });
  EXPECT_EQ(Count(track, "reference_jump"), 1);
  // From reading 99 to 101, the first that is believed, it is not known what happened.
  EXPECT_NEAR(track.rotation_deg()[2], 40.0 * kReadingInterval_s * 197, 1e-6);
}

// Before, all that was measured near an end of the turn was left out.
TEST(AWrappedAngle, IsReadAsOneThatRunsOn) {
  for (const ReferenceKind kind : {ReferenceKind::kStandAngles, ReferenceKind::kSensorAngle}) {
    for (const double end_deg : {180.0, 360.0}) {
      for (const double interval_s : {0.01, 0.1}) {
        ReferenceTrack runs_on, wrapped;
        runs_on.Start(Info(kind));
        wrapped.Start(Info(kind));
        for (int i = 0; i < 4000; ++i) {
          const double t_s = interval_s * i;
          // Rests and turns through both ends, with a digit of noise.
          const double angle_deg = 0.1 * (i % 2) + 900.0 * std::pow(std::sin(t_s / 8.0), 3);
          double read_deg = std::remainder(angle_deg, 360.0);
          if (end_deg == 360.0 && read_deg < 0.0) read_deg += 360.0;
          runs_on.Add(AngleSample{t_s, 2, angle_deg});
          wrapped.Add(AngleSample{t_s, 2, read_deg});
          ASSERT_NEAR(wrapped.rotation_deg()[2], runs_on.rotation_deg()[2], 1e-9) << t_s;
        }
        EXPECT_GE(Count(wrapped, "reference_wrapped"), 10);
        EXPECT_EQ(Count(wrapped, "reference_jump"), 0);
        EXPECT_EQ(Count(wrapped, "reference_outlier"), 0);
        EXPECT_EQ(Count(runs_on, "reference_wrapped"), 0);
      }
    }
  }
}

// Where the angle has left its turn before, nothing is wrapped.
TEST(AnAngleThatRunsOn, MayJumpByAWholeTurn) {
  for (const double step_deg : {360.0, -150.0}) {
    ReferenceTrack track;
    Feed(track, ReferenceKind::kStandAngles,
         [=](int i, double angle) { return i >= 100 ? angle + step_deg : angle; });
    EXPECT_EQ(Count(track, "reference_wrapped"), 0);
    ASSERT_EQ(Count(track, "reference_jump"), 1);
    const auto& defects = track.defects().defects();
    const auto jump = std::ranges::find_if(
        defects, [](const Defect& defect) { return defect.kind == "reference_jump"; });
    EXPECT_EQ(jump->where, step_deg == -150.0 ? "" : calibration::kByWholeTurns);
  }
}

INSTANTIATE_TEST_SUITE_P(Reference, WildReadings,
                         ::testing::Values(ReferenceKind::kStandAngles, ReferenceKind::kSensorAngle,
                                           ReferenceKind::kOrientation));

TEST(WildReadings, OfAnySizeCostNoDigitOfTheOthers) {
  ReferenceTrack track;
  Feed(track, ReferenceKind::kSensorAngle,
       [](int i, double angle) { return i % 10 == 5 ? 1e29 : angle; });
  EXPECT_NEAR(track.rotation_deg()[2], 40.0 * kReadingInterval_s * 199, 1e-9);
}

TEST(ReferenceTimes, MayBeNegative) {
  ReferenceTrack track;
  track.Start(Info(ReferenceKind::kSensorAngle));
  track.Add(AngleSample{-5.0, 2, 1.0});
  track.Add(AngleSample{-4.9, 2, 2.0});
  EXPECT_EQ(track.time_s(), -4.9);
}

// An orientation twice a second is slow, not lost.
TEST(SlowOrientation, IsNotLost) {
  ReferenceTrack track;
  track.Start(Info(ReferenceKind::kOrientation));
  for (int i = 0; i < 100; ++i) track.Add(OrientationSample{0.5 * i, AboutZ(3.0 * i)});
  EXPECT_EQ(Count(track, "lost_reference"), 0);
  EXPECT_NEAR(track.rotation_deg()[2], 3.0 * 99, 1e-9);
}

// A reading every 3 s or so: how often it comes is not known before the second interval.
TEST(SlowAngle, IsNotLost) {
  for (const ReferenceKind kind : {ReferenceKind::kSensorAngle, ReferenceKind::kStandAngles}) {
    ReferenceTrack track;
    track.Start(Info(kind));
    for (int i = 0; i < 100; ++i) track.Add(AngleSample{3.0 * i + 0.4 * std::sin(i), 2, 2.0 * i});
    EXPECT_EQ(Count(track, "lost_reference"), 0);
    EXPECT_NEAR(track.rotation_deg()[2], 2.0 * 99, 1e-9);
  }
}

// The second interval says that the first was no usual one, and every later one is judged by those
// after it.
TEST(AngleThatIsSilentAfterItsFirstReading, WasLostThere) {
  ReferenceTrack track;
  track.Start(Info(ReferenceKind::kSensorAngle));
  track.Add(AngleSample{0.0, 2, 0.0});
  track.Add(AngleSample{30.0, 2, 100.0});
  EXPECT_EQ(Count(track, "lost_reference"), 0);
  track.Add(AngleSample{30.1, 2, 100.0});
  EXPECT_EQ(Count(track, "lost_reference"), 1);
  EXPECT_EQ(track.lost_since_s(), 0.0);
  track.Add(AngleSample{30.2, 2, 100.0});
  EXPECT_FALSE(track.lost_since_s().has_value());
  track.Add(AngleSample{33.2, 2, 100.0});
  EXPECT_EQ(Count(track, "lost_reference"), 2);
}

}  // namespace
}  // namespace gyrobench::testing
