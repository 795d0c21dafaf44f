// Numbers with decimal commas are refused; a damaged line is not taken for them.
#include "recording/decimal_commas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"

namespace gyrobench::recording {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(DecimalCommas, AreRefusedWithTheFirstLineThatHasThem) {
  DecimalCommas commas("a.csv");
  try {
    for (int line = 2; line < 10; ++line) commas.Look("\"0,01\",-303,2,7\r", line, 3);
    FAIL();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("a.csv:2: found '\"0,01\",-303,2,7', which has 5 fields where the "
                                "header has 3 columns"),
                      HasSubstr("Accepted are numbers with a point")));
  }
}

// Of a short table too.
TEST(DecimalCommas, AreRefusedAtTheEndWhereThereWereFewLines) {
  DecimalCommas commas("a.csv");
  commas.Look("0,01,5", 2, 2);
  EXPECT_THROW(commas.End(), DataError);
}

TEST(DecimalCommas, AreNoneOfATableWithDamagedLines) {
  DecimalCommas commas("a.csv");
  for (int line = 2; line < 100; ++line) {
    commas.Accept();
    if (line % 10 == 0) commas.Look("1,2,3", line, 2);  // two lines run into one
  }
  for (int line = 100; line < 200; ++line) {
    commas.Look("0.01,5.5,7.5", line, 2);  // numbers with a point
    commas.Look("1", line, 2);             // too short
    commas.Look("1,2,3,4,5", line, 2);     // more than twice as many
  }
  commas.End();
}

}  // namespace
}  // namespace gyrobench::recording
