#include "calibration/signal/reference_track.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "calibration/signal/collector.h"
#include "kinematics/stand_frame.h"

namespace gyrobench::calibration {
namespace {

MeasurementInfo Stand() {
  MeasurementInfo info;
  info.reference = ReferenceKind::kStandAngles;
  info.stand_axis_present = {true, true, true};
  return info;
}

// Rest, and from `begin_s` on 100 deg/s^2 up to 40 deg/s.
double InnerAngle_deg(double t_s, double begin_s) {
  constexpr double kRate = 40.0, kAcceleration = 100.0;
  const double since_s = std::max(0.0, t_s - begin_s);
  const double ramp_s = std::min(since_s, kRate / kAcceleration);
  return 0.5 * kAcceleration * ramp_s * ramp_s + kRate * (since_s - ramp_s);
}

constexpr double kNever_s = 1e9;

// The inner axis turns at 12 s; the middle one, at 30 deg, is read from `middle_from_s` on.
Recording ReadFrom(const std::array<bool, 3>& announced, double middle_from_s) {
  Collector collector;
  MeasurementInfo info = Stand();
  info.gyro_present = {true, true, true};
  info.stand_axis_present = announced;
  collector.OnInfo(info);
  for (int sample = 0; sample < 8000; ++sample) {
    const double t_s = 0.005 * sample;
    collector.OnGyro({.t_s = t_s, .xi = {0.0, 0.0, t_s > 12.0 && t_s < 12.4 ? 40.0 : 0.0}});
    if (sample % 4 != 0) continue;
    const double inner_deg = std::clamp(t_s - 12.0, 0.0, 0.4) * 40.0;
    collector.OnAngle({.t_s = t_s, .axis = 2, .angle_deg = inner_deg});
    if (t_s > middle_from_s) collector.OnAngle({.t_s = t_s, .axis = 1, .angle_deg = 30.0});
  }
  return collector.Take();
}

std::int64_t CountOfSilent(const Recording& recording, const char* axis) {
  for (const Defect& defect : recording.defects) {
    if (defect.kind == kSilentReference && defect.where == axis) return defect.count;
  }
  return 0;
}

// A table may name the columns of axes that its stand does not have: what turns is measured as well
// as without them.
TEST(ReferenceTrack, AnAxisThatIsAnnouncedAndNeverReadIsTakenToStand) {
  const Recording with = ReadFrom({true, true, true}, kNever_s);
  const Recording without = ReadFrom({false, false, true}, kNever_s);
  EXPECT_EQ(with.info.stand_axis_present, without.info.stand_axis_present);
  ASSERT_EQ(without.columns.rests.size(), 2u);
  ASSERT_EQ(with.columns.rests.size(), 2u);
  // The first seconds wait for the axes.
  EXPECT_LT(with.columns.rests[0].begin.t_s, 5.1);
  EXPECT_EQ(with.columns.rests[0].end.t_s, without.columns.rests[0].end.t_s);
  EXPECT_EQ(with.columns.rests[1].begin.t_s, without.columns.rests[1].begin.t_s);
  for (const Node& node : with.columns.nodes) {
    EXPECT_EQ(node.table_deg[0], 0.0);
    EXPECT_EQ(node.table_deg[1], 0.0);
  }
  EXPECT_EQ(CountOfSilent(with, "outer"), 1);
  EXPECT_EQ(CountOfSilent(with, "middle"), 1);
  EXPECT_EQ(CountOfSilent(without, "outer"), 0);
}

TEST(ReferenceTrack, AnAxisThatIsReadLateIsUsedFromThenOn) {
  constexpr double kFrom_s = 20.0;
  const Recording recording = ReadFrom({false, true, true}, kFrom_s);
  EXPECT_EQ(CountOfSilent(recording, "middle"), 2);
  EXPECT_TRUE(recording.info.stand_axis_present[1]);
  ASSERT_FALSE(recording.columns.bad.empty());
  EXPECT_LT(recording.columns.bad.front().begin_s, 0.1);
  EXPECT_NEAR(recording.columns.bad.front().end_s, kFrom_s, 0.1);
  ASSERT_FALSE(recording.columns.rests.empty());
  EXPECT_NEAR(recording.columns.rests.back().begin.t_s, kFrom_s, 1.0);
  EXPECT_GT(recording.columns.rests.back().end.t_s, 38.0);
  EXPECT_EQ(recording.columns.nodes.back().table_deg[1], 30.0);
}

// Axes that are read in turn. At the begin of a motion the axis that turns was read before the
// others, and what a node says of it must not be of then: that would look like backlash.
TEST(ReferenceTrack, AMotionThatBeginsBetweenTwoReadingsIsInNoNodeTooLate) {
  for (const double interval_s : {0.02, 0.1}) {
    for (int phase = 0; phase < 20; ++phase) {
      const double begin_s = 5.0 + interval_s * phase / 20.0;
      Collector collector;
      MeasurementInfo info = Stand();
      info.gyro_present = {true, true, true};
      collector.OnInfo(info);
      int sample_number = 0;
      for (int reading = 0; reading * interval_s / 3.0 < 10.0; ++reading) {
        const double read_s = reading * interval_s / 3.0, step_s = 1e-4;
        for (; 0.005 * sample_number <= read_s + 0.02; ++sample_number) {
          const double t_s = 0.005 * sample_number;
          GyroSample sample;
          sample.t_s = t_s;
          sample.xi = {
              0.0, 0.0,
              (InnerAngle_deg(t_s + step_s, begin_s) - InnerAngle_deg(t_s, begin_s)) / step_s};
          collector.OnGyro(sample);
        }
        const int axis = (reading + 2) % 3;  // the inner axis first
        const double angle_deg = axis == 2 ? InnerAngle_deg(read_s, begin_s) : 0.0;
        collector.OnAngle(AngleSample{read_s, axis, angle_deg});
      }
      const Recording recording = collector.Take();
      ASSERT_GT(recording.columns.nodes.size(), 60u);
      for (const Node& node : recording.columns.nodes) {
        EXPECT_NEAR(node.table_deg[2], InnerAngle_deg(node.at.t_s, begin_s), 0.01)
            << "interval " << interval_s << " s, begin " << begin_s << " s, node " << node.at.t_s;
      }
    }
  }
}

// Three axes, read 2.28 ms one after the other five times a second: of the two nodes of each turn
// some lay microseconds apart, once in a beat with the gyro's samples, and such an interval had
// next to no noise.
TEST(ReferenceTrack, NoTwoNodesAtRestEndWithTheSameSample) {
  constexpr double kSample_s = 1.0 / 200.3, kAxis_s = 0.00228, kTurn_s = 0.2;
  Collector collector;
  MeasurementInfo info = Stand();
  info.gyro_present = {true, true, true};
  collector.OnInfo(info);
  int sample_number = 0;
  for (int turn = 0; turn < 1500; ++turn) {
    for (int axis = 0; axis < 3; ++axis) {
      const double read_s = turn * kTurn_s + axis * kAxis_s;
      for (; kSample_s * sample_number <= read_s + 0.02; ++sample_number) {
        GyroSample sample;
        sample.t_s = kSample_s * sample_number;
        sample.xi = {0.1, 0.2, 0.01 * (sample_number % 3)};
        collector.OnGyro(sample);
      }
      collector.OnAngle(AngleSample{read_s, axis, 0.0});
    }
  }
  const Recording recording = collector.Take();
  const std::vector<Node>& nodes = recording.columns.nodes;
  ASSERT_GT(nodes.size(), 1400u);
  for (std::size_t k = 1; k < nodes.size(); ++k) {
    if (nodes[k].at.t_s < 1.0) continue;  // it is not known yet that it rests
    ASSERT_GT(nodes[k].samples.t_s - nodes[k - 1].samples.t_s, 0.5 * kSample_s)
        << "at " << nodes[k].at.t_s;
  }
}

// Where the swinging axis reverses it is slower for a moment than the noise of one at rest seems to
// be: the reading of that one must not say when the node is, with the other carried on at its last
// rate. It was off by 10 mdeg, and found as a step of the angle.
TEST(ReferenceTrack, AnAxisAtRestIsInNoNodeWhileAnotherReverses) {
  constexpr double kAmplitude_deg = 5.0, kPeriod_s = 1.37, kNoise_deg = 0.002;
  const auto angle_deg = [](double t_s) {
    return t_s < 5.0 ? 0.0
                     : kAmplitude_deg *
                           (1.0 - std::cos(2.0 * std::numbers::pi * (t_s - 5.0) / kPeriod_s));
  };
  ReferenceTrack track;
  track.Start(Stand());
  std::mt19937_64 random(3);
  std::normal_distribution<double> noise(0.0, kNoise_deg);
  const auto read_deg = [&](double true_deg) {
    constexpr double kCount_deg = 360.0 / 131072.0;
    return kCount_deg * std::round((true_deg + noise(random)) / kCount_deg);
  };
  int led = 0, of_rest = 0;
  for (int i = 0; i < 100'000; ++i) {
    const double t_s = 0.001 * i;
    if (i % 11 == 0) {
      track.Add(AngleSample{t_s, 2, read_deg(angle_deg(t_s))});
      led += t_s > 6.0 && track.leading() ? 1 : 0;
    }
    for (const int axis : {0, 1}) {
      if (i % 200 != 50 + 90 * axis) continue;
      track.Add(AngleSample{t_s, axis, read_deg(0.0)});
      of_rest += t_s > 6.0 && track.leading() ? 1 : 0;
    }
  }
  EXPECT_EQ(of_rest, 0);
  EXPECT_GT(led, 8000);
}

// A recording that begins with a motion, the turning axis read once and then not for a while.
TEST(ReferenceTrack, AnAxisThatWasReadOnceIsNotTakenForOneAtRest) {
  constexpr double kBegin_s = 0.02, kSilentUntil_s = 0.18, kStep_s = 1e-4;
  Collector collector;
  MeasurementInfo info = Stand();
  info.gyro_present = {true, true, true};
  collector.OnInfo(info);
  int sample_number = 0;
  for (int reading = 0; reading < 1500; ++reading) {
    const double read_s = 0.02 / 3.0 * reading;
    for (; 0.005 * sample_number <= read_s + 0.02; ++sample_number) {
      GyroSample sample;
      sample.t_s = 0.005 * sample_number;
      sample.xi[2] =
          (InnerAngle_deg(sample.t_s + kStep_s, kBegin_s) - InnerAngle_deg(sample.t_s, kBegin_s)) /
          kStep_s;
      collector.OnGyro(sample);
    }
    const int axis = (reading + 2) % 3;
    if (axis == 2 && reading > 0 && read_s < kSilentUntil_s) continue;
    collector.OnAngle(
        AngleSample{read_s, axis, axis == 2 ? InnerAngle_deg(read_s, kBegin_s) : 0.0});
  }
  const Recording recording = collector.Take();
  ASSERT_GT(recording.columns.nodes.size(), 60u);
  for (const Node& node : recording.columns.nodes)
    EXPECT_NEAR(node.table_deg[2], InnerAngle_deg(node.at.t_s, kBegin_s), 0.01) << node.at.t_s;
}

// A table that only ever turns forward. Five or six readings make a mean, two of them nearly at one
// time: carried on along the gyro, it never gets beyond where the table stops.
TEST(ReferenceTrack, AMeanIsNeverCarriedOnBeyondWhereTheTableStops) {
  static constexpr double kRate = 20.0, kStop_s = 200.0, kAcceleration = 200.0;
  const auto angle_deg = [](double t_s) -> double {
    const double ramp_s = std::clamp(t_s - kStop_s, 0.0, kRate / kAcceleration);
    return kRate * (std::min(t_s, kStop_s) + ramp_s) - 0.5 * kAcceleration * ramp_s * ramp_s;
  };
  for (int phase = 0; phase < 20; ++phase) {
    Collector collector;
    MeasurementInfo info = Stand();
    info.gyro_present = {true, true, true};
    collector.OnInfo(info);
    int read = 0;
    constexpr double kSample_s = 0.001, kStep_s = 1e-6;
    for (double t_s = 198.0; t_s < 203.0; t_s += kSample_s) {
      GyroSample sample;
      sample.t_s = t_s;
      sample.xi[2] = (angle_deg(t_s + kStep_s) - angle_deg(t_s - kStep_s)) / 2.0 / kStep_s;
      collector.OnGyro(sample);
      const double read_s = 198.05 + 0.001 * phase + 0.02 * read;
      if (read_s + 0.05 > t_s) continue;
      ++read;
      collector.OnAngle(AngleSample{read_s, 2, angle_deg(read_s)});
      if (read % 3 == 0) collector.OnAngle(AngleSample{read_s + 0.002, 0, 0.0});
      if (read % 3 == 1) collector.OnAngle(AngleSample{read_s + 0.009, 1, 0.0});
    }
    const Recording recording = collector.Take();
    const double end = recording.columns.nodes.back().at.z[2];
    int means = 0;
    for (const Node& node : recording.columns.nodes) {
      if (!node.mean.output_known) continue;
      ++means;
      for (const Vector3& on : node.z_near) EXPECT_LT(node.mean.z[2] + on[2], end + 1e-3);
    }
    EXPECT_GT(means, 15);
  }
}

// Three axes that turn at once, each read at its own times; the true rotation by fine integration.
TEST(ReferenceTrack, AddsUpRotationAboutTheSensorsAxesFromThreeMovingAngles) {
  auto angles = [](double t) -> Vector3 {
    return {20 * t, 40 * std::sin(0.5 * t), 30 * std::sin(0.8 * t)};
  };
  auto rates = [](double t) -> Vector3 {
    return {20, 20 * std::cos(0.5 * t), 24 * std::cos(0.8 * t)};
  };
  ReferenceTrack track;
  track.Start(Stand());
  for (int i = 0; i <= 1500; ++i) {
    const double t = i / 150.0;
    const int axis = i % 3;
    track.Add(AngleSample{t, axis, angles(t)[static_cast<std::size_t>(axis)]});
  }
  Vector3 truth = {};
  const int steps = 100000;
  for (int i = 0; i < steps; ++i) {
    const double t = 10.0 * (i + 0.5) / steps;
    const Matrix3 j = kinematics::StandFrame().Rates(angles(t));
    const Vector3 w = rates(t);
    for (std::size_t c = 0; c < 3; ++c) {
      truth[c] += (j[c][0] * w[0] + j[c][1] * w[1] + j[c][2] * w[2]) * 10.0 / steps;
    }
  }
  // The axes' last readings are up to two thirds of a poll (13 ms) old.
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(track.rotation_deg()[c], truth[c], 0.6) << c;
}

TEST(ReferenceTrack, GivesTheSameRotationFromAQuaternionAsFromAngles) {
  MeasurementInfo info;
  info.reference = ReferenceKind::kOrientation;
  ReferenceTrack track;
  track.Start(info);
  for (int i = 0; i <= 1000; ++i) {
    const double half = 0.5 * 0.73 * i * std::numbers::pi / 180.0;
    track.Add(OrientationSample{0.01 * i, {std::cos(half), std::sin(half), 0, 0}});
  }
  EXPECT_NEAR(track.rotation_deg()[0], 730.0, 1e-6);
  EXPECT_NEAR(track.rotation_deg()[2], 0.0, 1e-9);
}

using Quaternion = std::array<double, 4>;

Quaternion Times(const Quaternion& p, const Quaternion& q) {
  return {p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
          p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
          p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3],
          p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1]};
}

// About x (1), y (2) or z (3).
Quaternion About(std::size_t axis, double angle_deg) {
  const double half = 0.5 * angle_deg * std::numbers::pi / 180.0;
  Quaternion q = {std::cos(half)};
  q[axis] = std::sin(half);
  return q;
}

// The quaternion is the sensor's own: mounting and leans are in it, and what is said of the stand
// does not turn it once more.
TEST(ReferenceTrack, AnglesOnAStandAsItIsAndTheSensorsQuaternionAreTheSameMotion) {
  MeasurementInfo by_angles = Stand();
  by_angles.geometry = {{90.0, -20.0, 35.0}, 3.0, -5.0};
  by_angles.site_latitude_deg = 55.75;
  by_angles.site_heading_deg = 20.0;
  MeasurementInfo by_quaternion = by_angles;
  by_quaternion.reference = ReferenceKind::kOrientation;
  ReferenceTrack angles, quaternion;
  angles.Start(by_angles);
  quaternion.Start(by_quaternion);
  // One axis after the other, there and back.
  for (int i = 0; i <= 6000; ++i) {
    const double t_s = 0.01 * i;
    Vector3 at = {};
    for (std::size_t a = 0; a < 3; ++a) {
      const double since_s = t_s - 20.0 * static_cast<double>(a);
      at[a] = 15.0 * (std::clamp(since_s, 0.0, 9.0) - std::clamp(since_s - 11.0, 0.0, 4.0));
    }
    for (int a = 0; a < 3; ++a) angles.Add(AngleSample{t_s, a, at[static_cast<std::size_t>(a)]});
    const StandGeometry& g = by_angles.geometry;
    Quaternion q = About(3, at[0]);
    for (const auto& [axis, angle_deg] : {std::pair{2U, g.outer_middle_deg},
                                          {1U, at[1]},
                                          {2U, g.middle_inner_deg},
                                          {3U, at[2]},
                                          {3U, g.mount_deg[2]},
                                          {2U, g.mount_deg[1]},
                                          {1U, g.mount_deg[0]}})
      q = Times(q, About(axis, angle_deg));
    quaternion.Add(OrientationSample{t_s, q});
  }
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(angles.rotation_deg()[c], quaternion.rotation_deg()[c], 1e-6) << c;
    EXPECT_NEAR(angles.earth_deg()[c], quaternion.earth_deg()[c], 1e-4) << c;
    for (std::size_t row = 0; row < 3; ++row)
      EXPECT_NEAR(angles.world_now()[row][c], quaternion.world_now()[row][c], 1e-9) << row << c;
  }
}

TEST(ReferenceTrack, BreaksWhereTheOrientationWasLost) {
  MeasurementInfo info;
  info.reference = ReferenceKind::kOrientation;
  ReferenceTrack track;
  track.Start(info);
  int breaks = 0;
  for (int i = 0; i <= 1000; ++i) {
    const double half = 0.5 * 0.2 * i * std::numbers::pi / 180.0;
    std::array<double, 4> q = {std::cos(half), 0, 0, std::sin(half)};
    if (i >= 400 && i < 500) q.fill(kMissing);
    track.Add(OrientationSample{0.01 * i, q});
    if (track.lost_since_s()) ++breaks;
  }
  EXPECT_EQ(breaks, 1);
  EXPECT_NEAR(track.rotation_deg()[2], 200.0 - 0.2 * 101, 1e-6)
      << "what turned unseen is not counted";
}

TEST(ReferenceTrack, KnowsEarthsRotationInTheSensorsFrame) {
  MeasurementInfo info = Stand();
  info.site_latitude_deg = 90.0;
  ReferenceTrack track;
  track.Start(info);
  for (int i = 0; i <= 3600 * 5; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      track.Add(AngleSample{0.2 * i + 0.01 * axis, axis, axis == 1 ? 90.0 : 0.0});
    }
  }
  // Middle axis at 90 deg: the sensor's y axis points up. At the pole that is Earth's axis.
  EXPECT_NEAR(track.earth_deg()[1], 15.041, 1e-3);
  EXPECT_NEAR(track.earth_deg()[2], 0.0, 1e-3);
}

TEST(ReferenceTrack, RestsOnlyWhenAllAxesRest) {
  ReferenceTrack track;
  track.Start(Stand());
  int begins = 0, ends = 0;
  for (int i = 0; i <= 3000; ++i) {
    const double t = i / 150.0;
    const int axis = i % 3;
    // The outer axis turns between 5 s and 6 s, the inner between 5.5 s and 8 s.
    const double outer = 9 * std::clamp(t - 5.0, 0.0, 1.0),
                 inner = 9 * std::clamp(t - 5.5, 0.0, 2.5);
    track.Add(AngleSample{t, axis, axis == 0 ? outer : axis == 2 ? inner : 0.0});
    begins += track.rest_began() ? 1 : 0;
    ends += track.rest_ended() ? 1 : 0;
    if (track.rest_ended()) {
      EXPECT_NEAR(track.ended_rest().last_at_rest_s, 5.0, 0.03);
    }
    if (track.rest_began() && t > 5) {
      EXPECT_NEAR(track.open_rest()->coarse_begin_s, 8.0, 0.03);
    }
  }
  EXPECT_EQ(begins, 2);
  EXPECT_EQ(ends, 1);
}

}  // namespace
}  // namespace gyrobench::calibration
