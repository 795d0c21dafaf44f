// A result that cannot be must not leave the bench without a word.
#include "calibration/estimators/plausibility.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/estimators/exchanged_axes.h"

namespace gyrobench::calibration {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// Of a gyro z whose true rate is `ratio` times what its nominal sensitivity says.
AnalysisResult ResultWith(double ratio) {
  AnalysisResult result;
  result.info.gear_ratio = 40.0;
  ScaleResult scale;
  scale.scale_error = ratio - 1.0;
  result.scale = {scale};
  return result;
}

TEST(Implausible, SaysNothingOfAnyPartThatIsSoldAndNothingWithoutANominalSensitivity) {
  for (const double ratio : {0.85, 0.97, 1.0, 1.05, 1.15, kMissing})
    EXPECT_THAT(Implausible(ResultWith(ratio)), IsEmpty()) << ratio;
}

TEST(Implausible, SaysWhatWasFoundWhatWasExpectedAndWhatToCheck) {
  EXPECT_THAT(Implausible(ResultWith(-58.8)),
              ElementsAre(AllOf(HasSubstr("gyro z is -5980 %"), HasSubstr("at most 20 %"),
                                HasSubstr("not mounted as declared"), HasSubstr("mount_x_deg"))));
  EXPECT_THAT(Implausible(ResultWith(-1.02)), ElementsAre(HasSubstr("opposite ways")));
  for (const double ratio : {0.126, 0.49, 2.03, 4.1, 8.2})
    EXPECT_THAT(Implausible(ResultWith(ratio)), ElementsAre(HasSubstr("range_deg_s"))) << ratio;
  for (const double ratio : {40.5, 1.0 / 41.0})
    EXPECT_THAT(Implausible(ResultWith(ratio)), ElementsAre(HasSubstr("gear ratio"))) << ratio;
  for (const double ratio : {57.0, 1.0 / 57.5})
    EXPECT_THAT(Implausible(ResultWith(ratio)), ElementsAre(HasSubstr("radians"))) << ratio;
  EXPECT_THAT(Implausible(ResultWith(0.3)), ElementsAre(HasSubstr("counts_per_turn")));
}

// Of a table whose columns are `unit`, where the sensor scales by itself.
AnalysisResult OfColumns(RateUnit unit, double ratio) {
  AnalysisResult result = ResultWith(ratio);
  result.info.gyro_unit = unit;
  return result;
}

TEST(Implausible, ValuesInAnotherUnitThanTheColumnsNameSuspectTheUnitAndNameTheColumn) {
  constexpr double kDegPerRad = 57.29578;
  constexpr RateUnit kRad = RateUnit::kRadPerSecond, kDeg = RateUnit::kDegPerSecond;
  EXPECT_THAT(Implausible(OfColumns(kRad, 0.99 / kDegPerRad)),
              ElementsAre(AllOf(HasSubstr("values of gyro_z_rad_s are in deg/s"),
                                HasSubstr("Name the column gyro_z_deg_s"))));
  EXPECT_THAT(Implausible(OfColumns(kDeg, 1.01 * kDegPerRad)),
              ElementsAre(AllOf(HasSubstr("values of gyro_z_deg_s are in rad/s"),
                                HasSubstr("Name the column gyro_z_rad_s"))));
  // 250 and 2000 deg/s in 16 bits.
  for (const double lsb : {131.0, 16.4}) {
    EXPECT_THAT(Implausible(OfColumns(kRad, 1.0 / (kDegPerRad * lsb))),
                ElementsAre(AllOf(HasSubstr("values of gyro_z_rad_s are counts"),
                                  HasSubstr("Name the column gyro_z_lsb"),
                                  HasSubstr("# gyro_lsb_per_deg_s = ..."))))
        << lsb;
    EXPECT_THAT(Implausible(OfColumns(kDeg, 1.0 / lsb)),
                ElementsAre(HasSubstr("values of gyro_z_deg_s are counts")))
        << lsb;
    AnalysisResult counts = ResultWith(lsb * 1.02);
    counts.info.gyro_units_per_deg_s = lsb;
    EXPECT_THAT(Implausible(counts), ElementsAre(HasSubstr("Name the column gyro_z_deg_s")));
  }
}

TEST(Implausible, AThousandthOfTheUnitSuspectsTheUnitAndNamesTheColumn) {
  constexpr double kDegPerRad = 57.29578;
  constexpr RateUnit kRad = RateUnit::kRadPerSecond, kDeg = RateUnit::kDegPerSecond;
  EXPECT_THAT(Implausible(OfColumns(kDeg, 0.98e-3)),
              ElementsAre(HasSubstr("values of gyro_z_deg_s are in mdeg/s. Divide them by 1000")));
  EXPECT_THAT(Implausible(OfColumns(kRad, -1.02e-3)),
              ElementsAre(HasSubstr("values of gyro_z_rad_s are in mrad/s. Divide them by 1000")));
  EXPECT_THAT(
      Implausible(OfColumns(kRad, 1e-3 / kDegPerRad)),
      ElementsAre(AllOf(HasSubstr("in mdeg/s"), HasSubstr("Name the column gyro_z_deg_s"))));
  AnalysisResult reference = OfColumns(kDeg, 1010.0);
  reference.info.reference = ReferenceKind::kSensorAngle;
  EXPECT_THAT(Implausible(reference), ElementsAre(HasSubstr("in thousandths of a degree")));
  reference.scale.front().scale_error = 1.0 / 357.0 - 1.0;
  EXPECT_THAT(Implausible(reference), ElementsAre(HasSubstr("are in turns")));
}

// The mistake shows through a mounting that is declared the other way round.
TEST(Implausible, AnAxisOfTheOtherSignSuspectsTheUnitAsWell) {
  constexpr double kDegPerRad = 57.29578;
  EXPECT_THAT(Implausible(OfColumns(RateUnit::kDegPerSecond, -kDegPerRad)),
              ElementsAre(HasSubstr("values of gyro_z_deg_s are in rad/s")));
}

// The sensitivity to be given is the data sheet's. What this part was measured to have would take
// away the very error that is looked for.
TEST(Implausible, NoMeasuredSensitivityIsAdvised) {
  EXPECT_THAT(Implausible(OfColumns(RateUnit::kDegPerSecond, 1.0 / 134.0)),
              ElementsAre(Not(HasSubstr("134"))));
}

// Whatever the gyro's unit is: the sensitivity that would explain it is that of no part.
TEST(Implausible, AReferenceInRadiansIsNamedBeforeTheGyro) {
  for (const RateUnit unit : {RateUnit::kLsb, RateUnit::kDegPerSecond, RateUnit::kRadPerSecond}) {
    AnalysisResult result = OfColumns(unit, 1.0 / 57.2);
    result.info.reference = ReferenceKind::kSensorAngle;
    result.info.gyro_units_per_deg_s = 131.0;
    EXPECT_THAT(Implausible(result),
                ElementsAre(AllOf(HasSubstr("Most likely the unit of the reference"),
                                  HasSubstr("Multiply them by 57.29578; or"))));
    result.info.reference = ReferenceKind::kOrientation;
    EXPECT_THAT(Implausible(result), ElementsAre(Not(HasSubstr("unit of the reference"))));
  }
}

// So many counts a deg/s and the degrees of a radian are about the same: both are named.
TEST(Implausible, AFactorOfBothUnitAndCountsNamesBoth) {
  EXPECT_THAT(Implausible(OfColumns(RateUnit::kDegPerSecond, 1.0 / 57.0)),
              ElementsAre(AllOf(HasSubstr("radian"), HasSubstr("counts"))));
  AnalysisResult counts = ResultWith(57.14);
  counts.info.gyro_units_per_deg_s = 57.14;  // 17.5 mdps a digit
  EXPECT_THAT(Implausible(counts), ElementsAre(HasSubstr("are no counts but deg/s")));
}

TEST(Implausible, OfClocksNotStartedTogetherNothingElseIsSuspected) {
  AnalysisResult result = ResultWith(40.5);
  ASSERT_THAT(Implausible(result), ElementsAre(HasSubstr("gear ratio")));
  result.two_clocks = "the clocks were not started together";
  EXPECT_THAT(Implausible(result), IsEmpty());
}

// Which of several measurements is wrong their factor together does not say.
TEST(Implausible, OfInputsThatDifferTheCauseThatEachAllowsIsNamed) {
  MeasurementInfo geared, plain;
  geared.source = "geared.csv";
  geared.gear_ratio = 40.0;
  plain.source = "plain.csv";
  const MeasurementInfo* const both[] = {&plain, &geared, &geared};
  const auto says = ImplausibleScale(40.5, SensorAxis::kZ, both);
  ASSERT_TRUE(says);
  EXPECT_THAT(*says, AllOf(HasSubstr("by what plain.csv says: the z axis hardly feels"),
                           HasSubstr("or by what geared.csv says: the factor is the gear ratio")));
  const MeasurementInfo* const alike[] = {&geared, &geared};
  EXPECT_THAT(
      *ImplausibleScale(40.5, SensorAxis::kZ, alike),
      AllOf(HasSubstr("Most likely the factor is the gear ratio"), Not(HasSubstr("geared.csv"))));
  EXPECT_FALSE(ImplausibleScale(1.05, SensorAxis::kZ, both));
}

TEST(Implausible, AnAxisThatTurnsAndFeelsNothingIsOneToo) {
  AnalysisResult result;
  result.unfollowed_deg = {0.0, 360.0, 0.0};
  EXPECT_THAT(Implausible(result),
              ElementsAre(AllOf(HasSubstr("the y axis of the sensor turned "), HasSubstr("360 deg"),
                                HasSubstr("not mounted as declared"))));
}

// The table turns to and fro about z; channel c puts out `gain[c]` of that rate.
Columns TurnsAboutZ(const Vector3& gain) {
  Columns columns;
  Vector3 z = {};
  for (int i = 0; i < 600; ++i) {
    const double rate_deg_s = i % 100 < 50 ? 0.0 : 20.0 * ((i / 100) % 2 == 0 ? 1 : -1);
    Node node;
    node.at.t_s = 0.1 * i;
    if (i > 0) {
      node.rotation_deg = columns.nodes.back().rotation_deg;
      node.rotation_deg[2] += 0.1 * rate_deg_s;
      for (std::size_t c = 0; c < 3; ++c)
        z[c] += 0.1 * (gain[c] * rate_deg_s + 3.0 + 0.01 * (i % 7));
    }
    node.at.z = z;
    columns.nodes.push_back(node);
  }
  return columns;
}

TEST(ExchangedAxes, AreNamedWhereAnotherChannelFollowsInWhateverUnitAndSense) {
  for (const double unit : {1.0, 0.0175, -131.0}) {
    const std::string says = FollowedByAnother(TurnsAboutZ({unit, 0, 0.01 * unit}), SensorAxis::kZ);
    EXPECT_THAT(says, AllOf(HasSubstr("about z is followed by the output of x"),
                            HasSubstr("Exchange the two columns"), HasSubstr("mount_x_deg")))
        << unit;
    EXPECT_THAT(FollowedByAnother(TurnsAboutZ({0.1 * unit, 0.05 * unit, unit}), SensorAxis::kZ),
                IsEmpty());
  }
  // A misaligned axis feels a part.
  EXPECT_THAT(FollowedByAnother(TurnsAboutZ({0.02, 1, 0.001}), SensorAxis::kZ),
              HasSubstr("followed by the output of y"));
  EXPECT_THAT(FollowedByAnother(TurnsAboutZ({0, 0, 0}), SensorAxis::kZ), IsEmpty());
  EXPECT_THAT(FollowedByAnother(TurnsAboutZ({1, 0, 0}), SensorAxis::kX), IsEmpty());
  EXPECT_THAT(FollowedByAnother(Columns(), SensorAxis::kZ), IsEmpty());
}

// The angle is named for an axis that the gyro does not have.
TEST(ExchangedAxes, AreNamedWhereTheAxisThatTurnsHasNoChannel) {
  MeasurementInfo info;
  info.gyro_present = {true, false, false};
  for (const double units : {1.0, 131.0}) {
    info.gyro_unit = units == 1.0 ? RateUnit::kDegPerSecond : RateUnit::kLsb;
    info.gyro_units_per_deg_s = units;
    EXPECT_THAT(FollowedByAnotherAlone(info, TurnsAboutZ({1.01 * units, 0, 0})),
                AllOf(HasSubstr("about z is followed by the output of gyro x (1.01"),
                      HasSubstr("there is no gyro z")));
    // A misaligned axis feels a part, and that is a measurement of it.
    EXPECT_EQ(FollowedByAnotherAlone(info, TurnsAboutZ({0.1 * units, 0, 0})), "");
    // A sensor turned by hand turns about its own axis at the same time, the right way round or not.
    for (const double scale : {1.0, -1.0, 3.0}) {
      Columns slanted = TurnsAboutZ({0.3 * scale * units, 0, 0});
      for (Node& node : slanted.nodes) node.rotation_deg[0] = 0.3 * node.rotation_deg[2];
      EXPECT_EQ(FollowedByAnotherAlone(info, slanted), "") << scale;
    }
  }
  info.gyro_present = {true, true, true};
  EXPECT_EQ(FollowedByAnotherAlone(info, TurnsAboutZ({131.0, 0, 0})), "")
      << "the axis has a channel: it says itself that it felt nothing";
  // Counts of a sensitivity that nobody gave.
  info.gyro_present = {true, false, false};
  info.gyro_units_per_deg_s.reset();
  EXPECT_EQ(FollowedByAnotherAlone(info, TurnsAboutZ({131.0, 0, 0})), "");
}

// From the 300th node on the output is `factor` times what it was, its offset with it.
Columns WithUnitChanged(Columns columns, double factor, std::size_t channel) {
  const double at = columns.nodes[300].at.z[channel];
  for (std::size_t i = 300; i < columns.nodes.size(); ++i) {
    double& z = columns.nodes[i].at.z[channel];
    z = at + factor * (z - at);
  }
  return columns;
}

TEST(UnitChangeWithin, IsSaidWithItsMomentAndItsFactor) {
  const Columns plain = TurnsAboutZ({0, 0, 131.0});
  for (const double factor : {1.0 / 57.29578, 57.29578, 131.0, 0.5, 2.0}) {
    EXPECT_THAT(UnitChangeWithin(WithUnitChanged(plain, factor, 2)),
                AllOf(HasSubstr("from 30.0 s on"), HasSubstr(fmt::format("{:.4g} times", factor))))
        << factor;
  }
}

TEST(UnitChangeWithin, IsNotSaidOfAPartOfOneSensitivity) {
  const Columns plain = TurnsAboutZ({0, 0, 131.0});
  EXPECT_EQ(UnitChangeWithin(plain), "");
  EXPECT_EQ(UnitChangeWithin(Columns()), "");
  // Readings of an axis at rest scatter, by more than a turn in all, and that is no turn.
  Columns noisy = WithUnitChanged(plain, 2.0, 2);
  for (std::size_t i = 0; i < noisy.nodes.size(); ++i)
    noisy.nodes[i].rotation_deg[0] = i % 2 == 0 ? 0.04 : -0.04;
  EXPECT_THAT(UnitChangeWithin(noisy), HasSubstr("from 30.0 s on"));
  EXPECT_EQ(UnitChangeWithin(TurnsAboutZ({1, 0, 0})), "") << "it feels nothing of what is turned";
  // As much as a part may be off, and of one that was hardly turned on the other side.
  EXPECT_EQ(UnitChangeWithin(WithUnitChanged(plain, 1.15, 2)), "");
  Columns once = plain;
  once.nodes.resize(310);
  EXPECT_EQ(UnitChangeWithin(WithUnitChanged(once, 2.0, 2)), "");
  // A unit is that of all channels.
  Columns both = TurnsAboutZ({0, 131.0, 131.0});
  for (Node& node : both.nodes) node.rotation_deg[1] = node.rotation_deg[2];
  EXPECT_EQ(UnitChangeWithin(WithUnitChanged(both, 2.0, 2)), "");
  EXPECT_NE(UnitChangeWithin(WithUnitChanged(WithUnitChanged(both, 2.0, 2), 2.0, 1)), "");
}

TEST(ExchangedAxes, AreTheCauseOfAResultThatCannotBe) {
  AnalysisResult result = ResultWith(500.0);
  result.scale.front().axis = SensorAxis::kZ;
  result.cause[2] = "two axes stand for each other";
  EXPECT_THAT(Implausible(result),
              ElementsAre(AllOf(HasSubstr("Most likely two axes"), Not(HasSubstr("gear")))));
}

}  // namespace
}  // namespace gyrobench::calibration
