// What a terminal says of a result, its page says too.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

#include "presentation/charter.h"
#include "presentation/markup.h"
#include "presentation/results.h"
#include "presentation/text_layout.h"
#include "tests/presentation/sample_content.h"

namespace gyrobench::presentation {
namespace {

using testing::IsEmpty;

std::string Replaced(std::string text, const std::vector<std::pair<std::string, std::string>>& by) {
  for (const auto& [from, to] : by) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
      text.replace(at, from.size(), to);
  }
  return text;
}

// Words and numbers without marks of punctuation, in small letters; "held-out" is two.
std::set<std::string> Words(const std::string& said) {
  const std::string text = std::regex_replace(said, std::regex("([A-Za-z])-([A-Za-z])"), "$1 $2");
  std::set<std::string> words;
  std::istringstream stream(text);
  for (std::string word; stream >> word;) {
    const std::size_t begin = word.find_first_not_of("(\"'!*-");
    if (begin == std::string::npos) continue;
    const std::size_t end = word.find_last_not_of(".,:;)\"'");
    if (end == std::string::npos || end < begin) continue;
    word = word.substr(begin, end + 1 - begin);
    for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    words.insert(word);
  }
  return words;
}

// A page as a reader sees it, typeset characters written as a terminal writes them.
std::set<std::string> WordsOfPage(const std::string& html) {
  std::string text =
      html.substr(html.find("</style>") == std::string::npos ? 0 : html.find("</style>"));
  text = std::regex_replace(text, std::regex("</?(code|b|span)[^>]*>"), "");
  text = std::regex_replace(text, std::regex("<[^>]*>"), " ");
  text = Replaced(text, {{"&lt;", "<"},
                         {"&gt;", ">"},
                         {"&quot;", "\""},
                         {"&#39;", "'"},
                         {"&amp;", "&"},
                         {"\u00A0", " "},
                         {"\u2007", ""},
                         {"\u2008", ""},
                         {"−", "-"},
                         {"√s", "sqrt(s)"},
                         {"⁻", "^-"}});
  const char* const up[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  for (int digit = 0; digit < 10; ++digit)
    text = Replaced(text, {{up[digit], "^" + std::to_string(digit)}});
  text = Replaced(text, {{"^-^", "^-"}});
  text = std::regex_replace(text, std::regex("(\\^-?[0-9]+)\\^([0-9])"), "$1$2");
  return Words(text);
}

std::set<std::string> WordsOfText(const Document& document) {
  std::string text = RenderText(document, Terminal());
  text = std::regex_replace(text, std::regex("e-0?([0-9]+)"), " × 10^-$1");
  return Words(text);
}

std::set<std::string> Missing(const std::set<std::string>& said, const std::set<std::string>& in) {
  std::set<std::string> missing;
  for (const std::string& word : said)
    if (!in.contains(word)) missing.insert(word);
  return missing;
}

ReportOptions WithoutCharts() {
  ReportOptions options;
  options.gnuplot = "/nowhere/gnuplot";
  return options;
}

TEST(AnalysisOnAPage, HasEveryWordOfTheTerminal) {
  const ReportContent content = AnalysisSample();
  EXPECT_THAT(Missing(WordsOfText(AnalysisDocument(*content.analysis)),
                      WordsOfPage(ReportHtml(content, WithoutCharts()))),
              IsEmpty());
}

TEST(AnalysisOnATerminal, HasEveryWordOfThePage) {
  const calibration::AnalysisResult analysis = *AnalysisSample().analysis;
  Charter none("/nowhere/gnuplot");
  std::set<std::string> said = WordsOfText(AnalysisDocument(analysis));
  said.merge(Words("Baseline estimates"));  // the title of the part of a page
  EXPECT_THAT(Missing(WordsOfPage(RenderPage(AnalysisPage(analysis), none).html()), said),
              IsEmpty());
}

// Effects of all owners, findings, rivals, three axes, an accelerometer.
TEST(TraceOnAPage, HasEveryWordOfTheTerminal) {
  ReportContent content = ThreeAxesSample();
  calibration::TraceResult& trace = *content.trace;
  for (auto& channel : trace.channels) channel.baseline.reference_degC = 31.25;
  trace.channels[2].effects[1].chosen_on = calibration::ChosenOn::kTrainingPart;
  trace.channels[2].effects[2].owner = calibration::EffectOwner::kBench;
  trace.reference_error = "the errors contain the reference's own";
  const std::set<std::string> said = WordsOfText(TraceDocument(trace));
  EXPECT_THAT(Missing(said, WordsOfPage(ReportHtml(content, WithoutCharts()))), IsEmpty());
  for (const char* of_both : {"catalogue", "nothing", "chosen", "windows", "rz(z", "white", "31.25",
                              "correction", "sensor's"})
    EXPECT_TRUE(said.contains(of_both)) << of_both;
}

}  // namespace
}  // namespace gyrobench::presentation
