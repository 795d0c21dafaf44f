// A slice of the vector trials: laws so loose that a sound calibration fails them by bad luck once
// in many thousands of seeds.
#include "tests/blind_trials/vector_trial.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gyrobench::blind_trials {
namespace {

// 81 numbers a part: one of them beyond five standard errors by chance in 20 000 parts.
TEST(VectorTrial, HoweverMountedEveryNumberIsWithinItsErrorAndTheErrorsAreNearTheBound) {
  double square = 0.0, count = 0.0;
  // On its side, which the recording says; a little askew, which nobody knows.
  for (const VectorOutcome& outcome :
       {RunVectorTrial(1, {90.0, 0.0, 0.0}), RunVectorTrial(2, {2.0, -1.0, 1.5}, false)}) {
    ASSERT_EQ(outcome.failure, "");
    EXPECT_EQ(outcome.effects, "bias.g_linear, bias.g_linear, bias.g_linear") << "what it has";
    for (const StatedNumber& number : outcome.numbers) {
      EXPECT_NEAR(number.estimate, number.truth, 5.0 * number.std_error)
          << number.group << " " << number.name;
      if (!(number.bound > 0.0)) continue;
      square += std::pow((number.estimate - number.truth) / number.bound, 2);
      count += 1.0;
    }
    // Some 10 000 rows: a spread of 0.007.
    for (const double rms : outcome.elsewhere_whitened_rms) EXPECT_LT(rms, 1.05);
  }
  EXPECT_LT(std::sqrt(square / count), 1.4);
}

}  // namespace
}  // namespace gyrobench::blind_trials
