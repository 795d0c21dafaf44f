#include "cli/run_display.h"

#include <gtest/gtest.h>

namespace gyrobench::cli {
namespace {

TEST(BarLine, FitsAnyTerminalAndDropsTheSegmentBeforeTheEstimate) {
  RunView view;
  view.segment = "turn 12 of 40";
  view.estimate = "scale z: 0.0076336 ± 0.0000021 deg/s per LSB";
  view.remaining_s = 130.0;
  view.progress = 0.3;
  for (int columns = 16; columns < 120; ++columns) {
    EXPECT_LE(presentation::DisplayWidth(BarLine(view, columns)), columns);
  }
  EXPECT_NE(BarLine(view, 119).find(view.segment), std::string::npos);
  const std::string narrow = BarLine(view, 90);
  EXPECT_EQ(narrow.find(view.segment), std::string::npos);
  EXPECT_NE(narrow.find(view.estimate), std::string::npos);
}

}  // namespace
}  // namespace gyrobench::cli
