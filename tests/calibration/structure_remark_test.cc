// What is said of structure in the residuals of a scale factor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/estimators/scale.h"

namespace gyrobench::calibration {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(RemarkOnStructure, CallsNoErrorGrownThatIsAsGoodAsTheSame) {
  EXPECT_THAT(RemarkOnStructure(1.7e-4, 1.004), HasSubstr("not white (p = 1.7e-04)"));
  EXPECT_THAT(RemarkOnStructure(1.7e-4, 1.004), Not(HasSubstr("standard error")));
  EXPECT_THAT(RemarkOnStructure(1e-12, 2.48), HasSubstr("(p < 1e-09)"));
  EXPECT_THAT(RemarkOnStructure(1e-12, 2.48), HasSubstr("is 2.48 times the model's"));
}

}  // namespace
}  // namespace gyrobench::calibration
