#include "presentation/text_layout.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/measurement.h"
#include "tests/words.h"

namespace gyrobench::presentation {
namespace {

TEST(DisplayWidth, CountsSignsNotBytesNorColourCodes) {
  EXPECT_EQ(DisplayWidth("1 ± 2"), 5);
  EXPECT_EQ(DisplayWidth("\x1b[31mred\x1b[0m"), 3);
}

TEST(AlignColumns, BeginsEveryColumnAtTheSamePlace) {
  const std::vector<std::vector<std::string>> rows = {
      {"a", "1 ± 2", "x"}, {"long", "3", "x"}, {"b"}};
  const auto lines = Lines(AlignColumns(rows, {Align::kLeft, Align::kRight, Align::kLeft}, 1));
  ASSERT_EQ(lines.size(), 3u);
  EXPECT_EQ(DisplayWidth(lines[0]), DisplayWidth(lines[1]));
  EXPECT_EQ(lines[2], " b");
}

TEST(Shorten, KeepsWithinTheWidthAndLeavesShortTextAlone) {
  const std::string text = "alpha ± 0.1 deg/s";
  for (int columns = 0; columns < 30; ++columns) {
    EXPECT_LE(DisplayWidth(Shorten(text, columns)), columns);
  }
  EXPECT_EQ(Shorten(text, 17), text);
}

TEST(Wrap, BreaksOnlyBetweenWordsAndLosesNone) {
  const std::string text = "one two three four five six seven";
  for (int columns = 8; columns < 40; ++columns) {
    std::string joined;
    for (const std::string& line : Lines(Wrap(text, columns, 2))) {
      EXPECT_LE(DisplayWidth(line), columns);
      joined += (joined.empty() ? "" : " ") + line.substr(line.find_first_not_of(' '));
    }
    EXPECT_EQ(joined, text);
  }
}

TEST(Wrap, BreaksBesideANumberWhoseGroupsAreApartAndNotInIt) {
  EXPECT_EQ(Wrap("samples, 24 351 of 7", 11, 0), "samples,\n24 351 of 7");
  EXPECT_EQ(Wrap("from 10 2000 times", 7, 0), "from 10\n2000\ntimes");
}

TEST(Bar, IsAlwaysAsWideAsAskedFor) {
  for (const double fraction : {-1.0, 0.0, 0.001, 0.5, 0.999, 1.0, 7.0, kMissing}) {
    EXPECT_EQ(DisplayWidth(Bar(fraction, 13)), 13);
  }
}

// Row of the topmost dot in each column of a drawn plot; -1 where there is none.
std::vector<int> TopDots(const std::vector<std::string>& lines) {
  std::vector<int> top;
  for (std::size_t row = 0; row < lines.size(); ++row) {
    std::string_view line = lines[row];
    std::size_t column = 0;
    for (std::size_t i = 0; i + 2 < line.size(); ++i) {
      if (static_cast<unsigned char>(line[i]) != 0xE2 ||
          (static_cast<unsigned char>(line[i + 1]) & 0xFC) != 0xA0) {
        continue;
      }
      if (top.size() <= column) top.resize(column + 1, -1);
      const bool blank = line.substr(i, 3) == "\u2800";
      if (!blank && top[column] < 0) top[column] = static_cast<int>(row);
      ++column;
      i += 2;
    }
  }
  return top;
}

TEST(DrawPlot, GoesUpWhereTheCurveGoesUp) {
  Plot plot;
  plot.x_label = "x";
  plot.y_label = "y";
  plot.y = [](double x) { return std::exp(2.0 * x); };
  const std::vector<int> top = TopDots(Lines(DrawPlot(plot)));
  ASSERT_GT(top.size(), 20u);
  for (std::size_t i = 1; i < top.size(); ++i) EXPECT_LE(top[i], top[i - 1]);
  EXPECT_LT(top.back(), top.front());
}

TEST(DrawPlot, KeepsItsSizeAndIsEmptyWithoutAValue) {
  Plot plot;
  plot.columns = 50;
  plot.rows = 8;
  plot.y = [](double x) { return x; };
  const auto lines = Lines(DrawPlot(plot));
  EXPECT_LE(lines.size(), 9u);
  for (const std::string& line : lines) EXPECT_LE(DisplayWidth(line), 50);
  plot.y = [](double) { return kMissing; };
  EXPECT_EQ(DrawPlot(plot), "");
}

}  // namespace
}  // namespace gyrobench::presentation
