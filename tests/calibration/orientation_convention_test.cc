// Which convention of a quaternion makes gyro and reference agree.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/signal/columns.h"
#include "calibration/signal/intake.h"

namespace gyrobench::calibration {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

MeasurementInfo Info(bool sensitivity_given) {
  MeasurementInfo info;
  info.gyro_present = {true, true, true};
  info.reference = ReferenceKind::kOrientation;
  if (sensitivity_given) info.gyro_units_per_deg_s = 131.0;
  return info;
}

// Turns to and fro about z alone, as read in a quaternion whose sense is `sense`.
Columns AboutZ(double sense, double units) {
  Columns columns;
  Vector3 z = {};
  for (int i = 0; i < 600; ++i) {
    const double t_s = 0.1 * i;
    const double angle = sense * 60.0 * (1.0 - std::cos(0.3 * t_s)) / 57.29578;
    z[2] = units * (60.0 * (1.0 - std::cos(0.3 * t_s)) + 0.5 * t_s);
    Node node;
    node.at = {t_s, z};
    node.world_x = {std::cos(angle), -std::sin(angle), 0.0};
    node.world_z = {0.0, 0.0, 1.0};
    columns.nodes.push_back(node);
  }
  return columns;
}

TEST(OtherConvention, IsNoneWhereTheOneGivenAgrees) {
  for (const bool given : {true, false})
    EXPECT_THAT(OtherConvention(Info(given), AboutZ(1.0, 131.0)), IsEmpty());
}

// About one axis the inverse is a mounting that points the other way.
TEST(OtherConvention, AboutOneAxisTheMountingIsNamedBesideTheInverse) {
  for (const bool given : {true, false}) {
    EXPECT_THAT(OtherConvention(Info(given), AboutZ(-1.0, 131.0)),
                AllOf(HasSubstr("is the inverse one"), HasSubstr("check the mounting")));
  }
}

// A sensitivity that is not the declared one is no convention, and rest says nothing.
TEST(OtherConvention, IsNoneWhereNoneAgrees) {
  EXPECT_THAT(OtherConvention(Info(true), AboutZ(1.0, 2.0 * 131.0)), IsEmpty());
  EXPECT_THAT(OtherConvention(Info(true), AboutZ(0.0, 131.0)), IsEmpty());
  EXPECT_THAT(OtherConvention(Info(true), Columns()), IsEmpty());
  MeasurementInfo angles = Info(true);
  angles.reference = ReferenceKind::kStandAngles;
  EXPECT_THAT(OtherConvention(angles, AboutZ(-1.0, 131.0)), IsEmpty());
}

}  // namespace
}  // namespace gyrobench::calibration
