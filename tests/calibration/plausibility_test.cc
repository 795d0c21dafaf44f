// A result that cannot be must not leave the bench without a word.
#include "calibration/estimators/plausibility.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gyrobench::calibration {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

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

TEST(Implausible, AnAxisThatTurnsAndFeelsNothingIsOneToo) {
  AnalysisResult result;
  result.unfollowed_deg = {0.0, 360.0, 0.0};
  EXPECT_THAT(Implausible(result),
              ElementsAre(AllOf(HasSubstr("the y axis of the sensor turned "), HasSubstr("360 deg"),
                                HasSubstr("not mounted as declared"))));
}

}  // namespace
}  // namespace gyrobench::calibration
