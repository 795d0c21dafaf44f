#include "presentation/chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "presentation/charter.h"

namespace gyrobench::presentation {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Chart OneCurve(std::vector<double> x, std::vector<double> y) {
  Chart chart;
  chart.title = "Error";
  chart.x_label = "time [s]";
  chart.y_label = "error [deg]";
  chart.curves = {{"before", CurveLook::kBefore, std::move(x), std::move(y), {}}};
  return chart;
}

TEST(Chart, CountsOnlyPointsThatCanBeDrawn) {
  Chart chart = OneCurve({0, 1, kNaN, 3, 4}, {1, kNaN, 2, kInfinity, -4});
  EXPECT_EQ(CountPoints(chart), 2u);
  chart.log_axes = true;
  EXPECT_EQ(CountPoints(chart), 0u);
}

TEST(Chart, BreaksTheCurveWhereAValueIsMissing) {
  const std::string script = GnuplotScript(OneCurve({0, 1, 2}, {5, kNaN, 7}));
  EXPECT_THAT(script, HasSubstr("0 5 5 5\n\n2 7 7 7\n"));
  EXPECT_THAT(script, Not(HasSubstr("nan")));
}

// gnuplot evaluates `commands` and @macros outside of single quotes.
TEST(Chart, QuotesAllTextForGnuplot) {
  Chart chart = OneCurve({0, 1}, {1, 2});
  chart.x_label = "a' `touch pwned`\n! touch pwned";
  const std::string script = GnuplotScript(chart);
  EXPECT_THAT(script, HasSubstr("set xlabel 'a'' `touch pwned` ! touch pwned'"));
}

TEST(Charter, SaysWhatToInstallWhereThereIsNoGnuplot) {
  const auto drawn = Charter("/nowhere/gnuplot").Draw(OneCurve({0, 1}, {1, 2}));
  EXPECT_TRUE(drawn.figure.empty());
  EXPECT_THAT(drawn.why_not, HasSubstr("apt-get install gnuplot-nox"));
}

TEST(Charter, SaysWhatAGnuplotThatFailsSays) {
  const auto drawn = Charter("false").Draw(OneCurve({0, 1}, {1, 2}));
  EXPECT_TRUE(drawn.figure.empty());
  EXPECT_THAT(drawn.why_not, HasSubstr("status 1"));
}

TEST(Charter, GivesTheReasonForAChartWithoutPoints) {
  Chart chart = OneCurve({kNaN}, {1});
  chart.why_empty = "no temperature";
  EXPECT_EQ(Charter().Draw(chart).why_not, "no temperature");
}

TEST(InlineSvg, GivesEachFigureIdsOfItsOwn) {
  const std::string svg =
      "<?xml version=\"1.0\"?><svg viewBox=\"0 0 1 1\" xmlns=\"http://www.w3.org/2000/svg\">"
      "<title>x</title><path id='a'/><use xlink:href='#a'/><g filter='url(#a)'/>"
      "<text> id='a' ]]></text></svg>\n";
  const std::string page = InlineSvg(svg, "f1-", "a \"label\"").html();
  EXPECT_EQ(page,
            "<svg role=\"img\" aria-label=\"a &quot;label&quot;\" viewBox=\"0 0 1 1\" >"
            "<path id='f1-a'/><use href='#f1-a'/><g filter='url(#f1-a)'/>"
            "<text> id='a' ]]&gt;</text></svg>\n");
}

TEST(InlineSvg, RefusesAnSvgThatWasCutShort) {
  EXPECT_TRUE(InlineSvg("<svg><path d='M 0", "f-", "").empty());
  EXPECT_TRUE(InlineSvg("", "f-", "").empty());
}

}  // namespace
}  // namespace gyrobench::presentation
