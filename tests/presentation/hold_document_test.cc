// What a calibration by held poses says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "presentation/results.h"
#include "presentation/text_layout.h"

namespace gyrobench::presentation {
namespace {

using testing::HasSubstr;

// What was done stands under the input that it was done with.
TEST(HoldDocument, IndentsWhatWasDoneWithAnInput) {
  calibration::HoldResult result;
  result.inputs.emplace_back().info.source = "poses.csv";
  result.faces = {{"+x", 10.0, true}, {"-x", 90.0, false}};
  result.missing = {"too few poses"};
  const std::string text = RenderText(HoldDocument(result), {});
  EXPECT_THAT(text, HasSubstr("poses.csv: "));
  EXPECT_THAT(text, HasSubstr("\n  faces held up: +x; not: -x\n"));
  EXPECT_THAT(text, HasSubstr("\n  no calibration: too few poses\n"));
}

// "Nothing beyond the baseline" is a trace's: here there is none.
TEST(HoldDocument, NamesNoBaseline) {
  calibration::HoldResult result;
  result.verdict = calibration::Verdict::kNone;
  result.summary = "Nothing beyond matrix, offset and the accelerometer's calibration.";
  const std::string text = RenderText(HoldDocument(result), {});
  EXPECT_THAT(text, HasSubstr("Beyond the calibration: nothing\n  Nothing beyond matrix"));
  EXPECT_THAT(text, testing::Not(HasSubstr("baseline")));
  result.verdict = calibration::Verdict::kPartlyExplained;
  EXPECT_THAT(RenderText(HoldDocument(result), {}),
              HasSubstr("Beyond the calibration: partly explained\n"));
}

}  // namespace
}  // namespace gyrobench::presentation
