// A document on a terminal: nothing is lost for want of room.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "tests/presentation/sample_content.h"
#include "tests/words.h"

namespace gyrobench::presentation {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string Rendered(Table table, int columns) {
  Document document;
  Add(document, std::move(table));
  return RenderText(document, OfColumns(columns));
}

std::multiset<std::string> WordsOf(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

int WidestLine(const std::string& text) {
  int widest = 0;
  for (const std::string& line : Lines(text)) widest = std::max(widest, DisplayWidth(line));
  return widest;
}

Table Errors() {
  Table table{{{}, {"", Column::Kind::kNumber}, {}, {"", Column::Kind::kNote}}, {}};
  table.Add({"angle error, held out", Number("0.0287 → 0.0284"), Unit("deg"),
             "windows of 10 s, effects chosen and fitted without them"});
  table.Add({"whitened rms", Number("0.963 → 0.954"), Unit(""), "1: as the noise explains"});
  return table;
}

TEST(TextOfATable, BreaksANoteOrPutsItBeneathAndNeverLeavesItOut) {
  const std::multiset<std::string> wide = WordsOf(Rendered(Errors(), 400));
  for (int columns = 24; columns <= 130; ++columns) {
    const std::string text = Rendered(Errors(), columns);
    EXPECT_EQ(WordsOf(text), wide) << text;
    EXPECT_LE(WidestLine(text), columns) << text;
  }
}

TEST(TextOfATable, KeepsARowInOneLineWhereThereIsRoom) {
  EXPECT_EQ(Lines(Rendered(Errors(), 110)).size(), 2u);
  EXPECT_EQ(Lines(RenderText({{Errors()}}, Terminal())).size(), 2u);
}

TEST(TextOfATable, PutsTheCellsOfARowThatIsTooWideBeneathEachOther) {
  Table table{{{"effect"}, {"of"}, {"angle error, deg", Column::Kind::kNumber}, {"chance"}}, {}};
  table.Add({"angle.latency", "bench", Number("0.0287 → 0.0284"), Number("p = 1.1e-08")});
  EXPECT_EQ(Rendered(table, 40),
            "effect\n"
            "angle.latency\n"
            "  of: bench\n"
            "  angle error, deg: 0.0287 → 0.0284\n"
            "  chance: p = 1.1e-08\n");
}

TEST(TextOfATable, AlignsCountsOnTheRight) {
  Table table{{{"Kind"}, {"Count", Column::Kind::kCount}}, {}};
  table.Add({"gap", Number("2")});
  table.Add({"repeated_time", Number("1 412")});
  EXPECT_EQ(Rendered(table, 80),
            "Kind           Count\n"
            "gap                2\n"
            "repeated_time  1 412\n");
}

TEST(TextOfFacts, HasNoColonWhereNothingFollows) {
  Facts facts;
  facts.facts = {{Code("bias.g"), {}, {}}, {Code("scale.g"), "turn", {}}};
  EXPECT_EQ(RenderText({{facts}}, Terminal()), "bias.g\nscale.g: turn\n");
}

// No number is cut and none is lost: each of the wide text stands in the narrow one as it is, and
// at least as often: the heads of a table that is broken up stand with each of its rows.
TEST(TextOfATrace, SaysEveryNumberOnATerminalOfAnyWidth) {
  const Document document = TraceDocument(*ThreeAxesSample().trace);
  const std::multiset<std::string> wide = WordsOf(RenderText(document, OfColumns(400)));
  for (const int columns : {50, 60, 80, 90, 100, 110, 120}) {
    const std::string text = RenderText(document, OfColumns(columns));
    EXPECT_THAT(text, Not(HasSubstr("…")));
    EXPECT_LE(WidestLine(text), columns);
    const std::multiset<std::string> words = WordsOf(text);
    for (const std::string& word : wide) {
      const bool number = word.find_first_of("0123456789") != std::string::npos;
      if (number) {
        EXPECT_GE(words.count(word), wide.count(word)) << word << ", " << columns;
      }
    }
  }
}

}  // namespace
}  // namespace gyrobench::presentation
