#include "presentation/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "base/error.h"
#include "presentation/markup.h"
#include "tests/presentation/sample_content.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::presentation {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

std::ptrdiff_t CountFiles(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

std::string ReadFile(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The charts have tests of their own; most of these need none.
ReportOptions WithoutCharts() {
  ReportOptions options;
  options.gnuplot = "/nowhere/gnuplot";
  return options;
}

std::string Html(const ReportContent& content) { return ReportHtml(content, WithoutCharts()); }

// A table has no run and often no serial number: what it is must be told all the same.
TEST(Report, NamesFileSensorDateAndSamplesOfATableAtItsHead) {
  ReportContent content = ExplainedSample();
  content.provenance = {};
  content.provenance.written_utime = 1'795'275'012'000'000;
  content.provenance.files = {{"turns.csv.gz", "", -1}};
  content.trace->inputs.resize(1);
  content.trace->inputs.front().samples = 65'432;
  const std::string html = Html(content);
  const std::string head =
      html.substr(html.find("<header>"), html.find("</header>") - html.find("<header>"));
  for (const char* part : {"turns.csv.gz", "Sensor not named", "2026-11-21", "432 samples in "})
    EXPECT_THAT(head, HasSubstr(part));
  content.provenance.sensor = "MPU-17";
  EXPECT_THAT(Html(content), HasSubstr("Sensor MPU-17"));
}

TEST(Report, ShowsNoNoiseThatTheDataCouldNotHaveShown) {
  ReportContent content = ExplainedSample();
  auto& noise = content.trace->channels.front().noise;
  noise = {0.005, 3e-9, 0.0};
  content.trace->channels.front().effects[1].p_value = 0.01;  // of a power of ten of its own
  for (auto& input : content.trace->inputs) input.duration_s = 600.0;
  const std::string html = Html(content);
  EXPECT_THAT(html, HasSubstr("not seen"));
  EXPECT_THAT(html, Not(HasSubstr("10⁻⁹")));
}

TEST(Report, ShowsAllThatTheTraceSays) {
  const ReportContent content = ExplainedSample();
  const std::string html = Html(content);
  const auto& channel = content.trace->channels.front();
  for (const auto& effect : channel.effects) {
    EXPECT_THAT(html, HasSubstr(Markup::Text(effect.id).html()));
    EXPECT_THAT(html, HasSubstr(Markup::Text(effect.cause).html()));
    EXPECT_THAT(html, HasSubstr(Markup::Text(effect.equation).html()));
    EXPECT_THAT(html, HasSubstr(Markup::Text(effect.settled_by).html()));
    for (const auto& rival : effect.rivals) EXPECT_THAT(html, HasSubstr(rival));
  }
  for (const auto& parameter : channel.baseline.parameters) {
    EXPECT_THAT(html, HasSubstr("<td>" + parameter.name + "</td>"));
  }
  for (const auto& effect : channel.unidentifiable) {
    EXPECT_THAT(html, HasSubstr(effect.id));
    EXPECT_THAT(html, HasSubstr(Markup::Text(effect.settled_by).html()));
  }
  for (const auto& defect : content.trace->inputs.front().defects) {
    EXPECT_THAT(html, HasSubstr(defect.kind));
    EXPECT_THAT(html, HasSubstr(defect.where));
  }
  for (const auto& file : content.provenance.files) EXPECT_THAT(html, HasSubstr(file.sha256));
}

TEST(Report, PutsTheVerdictBeforeEverythingElse) {
  const std::string html = Html(ExplainedSample());
  const std::size_t verdict = html.find("Explained</span>");
  EXPECT_LT(verdict, html.find("before and after</h2>"));
  EXPECT_LT(verdict, html.find("<h2>Parameters"));
  EXPECT_LT(html.find("<h2>Parameters"), html.find("<h2>Rivals"));
  EXPECT_LT(html.find("<h2>Rivals"), html.find("<h2>Inputs and provenance"));
}

TEST(Report, TellsTheGyrosEffectsFromTheReferences) {
  const std::string html = Html(ExplainedSample());
  const std::size_t gyro = html.find("<h3>The gyro&#39;s own");
  const std::size_t reference = html.find("<h3>The reference&#39;s");
  ASSERT_NE(gyro, std::string::npos);
  ASSERT_NE(reference, std::string::npos);
  EXPECT_LT(gyro, html.find("<code>bias.of(supply_V)</code></h4>"));
  EXPECT_LT(html.find("<code>bias.of(supply_V)</code></h4>"), reference);
  EXPECT_LT(reference, html.find("<code>angle.eccentricity_1</code></h4>"));
}

TEST(Report, GivesTheSummaryWhereNoEffectWasNamed) {
  const ReportContent content = SilentSample();
  EXPECT_THAT(Html(content), HasSubstr(content.trace->channels.front().summary));
}

TEST(Report, SaysOnceWhatEffectsOfOneIdShareAndEachNumberOfThem) {
  ReportContent content = ExplainedSample();
  auto& effects = content.trace->channels.front().effects;
  auto ripple = effects.front();
  ripple.id = "angle.ripple";
  ripple.cause = "lines of the encoder";
  ripple.equation = "a sin(k phi)";
  for (int i = 1; i <= 4; ++i) {
    ripple.parameters = {{"k", 100.25 * i, "1/turn", 0.01, 0.01}};
    effects.push_back(ripple);
  }
  const std::string html = Html(content);
  EXPECT_EQ(Count(html, ripple.cause), 1);
  EXPECT_EQ(Count(html, ripple.equation), 1);
  for (const char* value : {"100.25", "200.50", "300.75", "401.00"})
    EXPECT_EQ(Count(html, value), 2) << value;  // with the effect, and among all parameters
}

TEST(Report, SaysReasonsAndRemarksThatHoldForAllAxesOnce) {
  ReportContent content = ThreeAxesSample();
  for (auto& channel : content.trace->channels) {
    const int own = static_cast<int>(channel.axis) + 1;
    channel.remarks = {"the temperature stayed"};
    channel.unidentifiable = {{"bias.hysteresis", "it only rose", "Cool."},
                              {"scale.temperature", "it only rose", "Turn."},
                              {"scale.g", "its bound is 0.0" + std::to_string(own), "Tilt."}};
    channel.unidentifiable.back().limit = {0.01 * own, 0.001, "1/g"};
  }
  const std::string html = Html(content);
  EXPECT_EQ(Count(html, "the temperature stayed"), 1);
  EXPECT_EQ(Count(html, "it only rose"), 1);
  EXPECT_EQ(Count(html, "its bound here is beyond the largest size of such parts"), 1);
  for (const char* figure : {"0.01\u00A01/g, of parts 0.001", "0.02\u00A01/g, of parts 0.001",
                             "0.03\u00A01/g, of parts 0.001"})
    EXPECT_EQ(Count(html, figure), 1) << figure;
  for (const char* id : {"bias.hysteresis", "scale.temperature"}) EXPECT_EQ(Count(html, id), 1);
}

TEST(Report, ShowsACurveWhoseEndsHaveNoError) {
  ReportContent content = ExplainedSample();
  auto& effect = content.trace->channels.front().effects[1];
  effect.origin = calibration::EffectOrigin::kEmpirical;
  effect.id = "empirical(T)";
  effect.parameters = {{"change", 0.0512, "deg/s", 0.0031, 0.0030},
                       {"from", 27.0, "degC", kMissing, kMissing},
                       {"to", 29.5, "degC", kMissing, kMissing}};
  const std::string html = Html(content);
  EXPECT_THAT(
      html,
      HasSubstr(
          "<td>change</td><td class=\"number\">0.0512\u00A0±\u00A00.0031</td><td>deg/s</td>"));
  EXPECT_THAT(html, HasSubstr("<td>from</td><td class=\"number\">27\u2008"));
  EXPECT_THAT(html, HasSubstr("<td>to</td><td class=\"number\">29.5\u2007"));
  EXPECT_THAT(html, Not(HasSubstr("\u00A0nan")));
  EXPECT_THAT(html, Not(HasSubstr(">nan")));
}

TEST(Report, DrawsNoDependenceOnAQuantityThatStayedTheSame) {
  ReportContent content = ExplainedSample();
  content.trace->channels.front().curves.rate_error_by_rate_deg_s = {{0.0}, {0.1}, {0.0}};
  EXPECT_THAT(Html(content), HasSubstr("the sensor never turned about this axis"));
}

TEST(Report, GivesNoVerdictOnAnAxisThatWasNotFitted) {
  ReportContent content = SilentSample();
  auto& channel = content.trace->channels.front();
  channel.baseline = {};
  channel.summary.clear();
  const std::string html = Html(content);
  EXPECT_THAT(html, HasSubstr("Not traced"));
  EXPECT_THAT(html, Not(HasSubstr("accounts for all")));
}

TEST(Report, GivesTheIntervalOfTheErrorBeforeAndAfter) {
  const std::string html = Html(ExplainedSample());
  EXPECT_THAT(html, HasSubstr("0.571\u00A0→\u00A00.150 deg"));
  EXPECT_THAT(html, HasSubstr("73.7\u00A0% less (95\u00A0%: 71.2 to 76.3\u00A0% less)"));
}

// No line of a page ends within a number of a table, however narrow its column.
TEST(Report, KeepsNumbersOfTablesWhole) {
  const std::string html = Html(ExplainedSample());
  EXPECT_THAT(html, HasSubstr("<td class=\"number\">0.571\u00A0→\u00A00.182</td>"));
  EXPECT_THAT(html, HasSubstr("<span class=\"number\">68.1\u00A0%</span> less"));
  EXPECT_THAT(html, HasSubstr("<span class=\"number\">p\u00A0=\u00A03.4\u00A0×\u00A010⁻⁹</span>"));
}

TEST(Report, WritesThePowersOfTenOfRemarksAsThoseOfTables) {
  ReportContent content = SilentSample();
  content.trace->remarks = {"the residuals are not white (p = 1.7e-04); see 1e-04.csv"};
  EXPECT_THAT(Html(content), HasSubstr("(p = 1.7\u00A0×\u00A010⁻⁴); see 1e-04.csv"));
}

// The daemon's record names no file.
TEST(Report, NamesTheRunWhereItsMeasurementHasNoNameOfItsOwn) {
  ReportContent content = ExplainedSample();
  content.trace->inputs.front().file.clear();
  EXPECT_THAT(Html(content), HasSubstr("<td>run 20261121-153012-full-sequence</td>"));
}

TEST(Report, PadsNeitherCountsNorDurations) {
  ReportContent content = ExplainedSample();
  content.trace->inputs.push_back(content.trace->inputs.front());
  content.trace->inputs.back().duration_s = 2.5;
  EXPECT_THAT(Html(content), HasSubstr(">37\u00A0min\u00A042\u00A0s</td>"));
}

TEST(Report, GivesEachParameterOfTheProcedureItsUnit) {
  const std::string html = Html(ExplainedSample());
  EXPECT_THAT(html, HasSubstr("<code>rate_deg_s</code></dt>\n<dd>20\u00A0deg/s</dd>"));
  EXPECT_THAT(html, HasSubstr("<code>axes</code></dt>\n<dd>z</dd>"));
}

// Charts, steps and defects count from the power-on where it is known; so does what was said.
TEST(Report, CountsAllTimesFromOneZeroAndSaysWhichItIs) {
  ReportContent content = ExplainedSample();
  std::string html = Html(content);
  EXPECT_THAT(html, HasSubstr("count from the begin of the run"));
  EXPECT_THAT(html, HasSubstr(">2.4\u00A0min</td>"));
  content.provenance.run.started_utime = 0;  // of a table
  EXPECT_THAT(Html(content), HasSubstr("count as those of the measurement do"));
  content.trace->inputs.resize(2);
  EXPECT_THAT(Html(content), HasSubstr("in charts the measurements follow one another"));
  content.trace->inputs.resize(1);
  content.provenance.run.started_utime = ExplainedSample().provenance.run.started_utime;
  content.provenance.run.power_on_utime = content.provenance.run.started_utime - 600'000'000;
  html = Html(content);
  EXPECT_THAT(html, HasSubstr("count from the sensor&#39;s power-on, everywhere on this page; the "
                              "run began 10 min 00 s after it"));
  EXPECT_THAT(html, HasSubstr(">12.4\u00A0min</td>"));
}

// A record that was damaged says so on its page, and no time is made up for what has none.
TEST(Report, NamesWhatCouldNotBeReadOfTheRun) {
  ReportContent content = ExplainedSample();
  content.provenance.run.said = {{kMissing, "manoeuvre 1"}};
  content.provenance.run.damage = {"procedure: expected a text, found 5: it is left out",
                                   "said[0].t_s: expected a number, found true: it is left out"};
  const std::string html = Html(content);
  for (const std::string& says : content.provenance.run.damage) EXPECT_THAT(html, HasSubstr(says));
  EXPECT_THAT(html, HasSubstr(">–</td><td>manoeuvre 1</td>"));
}

TEST(Report, SaysBesideTheBaselineWhichOfItsNumbersTheTraceNamesEffectsOf) {
  ReportContent content = ThreeAxesSample();
  EXPECT_THAT(Html(content), HasSubstr("the trace names scale.cubic: alpha holds for the rates"));
}

TEST(Report, SaysWhoseTheParametersOfAnEffectAre) {
  const std::string html = Html(ExplainedSample());
  EXPECT_THAT(html, HasSubstr("<code>angle.eccentricity_1</code> (the reference&#39;s, not the "
                              "sensor&#39;s)</td>"));
  EXPECT_THAT(html, HasSubstr("<code>scale.cubic</code></td>"));
}

TEST(Report, SaysThatThereIsNoTrace) {
  EXPECT_THAT(Html(AnalysisSample()), HasSubstr("was not traced to effects"));
  EXPECT_THAT(Html({}), HasSubstr("was not traced to effects"));
}

TEST(Report, IsWrittenWithoutGnuplotAndSaysWhatToInstall) {
  const std::string html = Html(ExplainedSample());
  EXPECT_THAT(html, Not(HasSubstr("<svg")));
  EXPECT_THAT(html, HasSubstr("apt-get install gnuplot-nox"));
  EXPECT_THAT(html, HasSubstr("Allan deviation at rest"));
}

TEST(Report, DrawsNoFileAndRunsNoCommandThatATextNames) {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::create_directory(folder / "work");
  fs::current_path(folder / "work");
  const std::string html = ReportHtml(HostileSample());
  fs::current_path(before);
  EXPECT_TRUE(fs::is_empty(folder / "work"));
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;"));
}

TEST(Report, TabulatesTheThreeAxesWithTheirErrors) {
  const std::string html = Html(ThreeAxesSample());
  EXPECT_THAT(html, HasSubstr("<h2>Three axes</h2>"));
  EXPECT_THAT(html, HasSubstr("89.70000\u00A0±\u00A00.00010"));
  EXPECT_THAT(html, HasSubstr("1.0000000\u00A0±\u00A00.0000013"));
  EXPECT_THAT(html, HasSubstr("deg/s per LSB"));
  EXPECT_THAT(html, HasSubstr("do not tell gravity along y"));
  EXPECT_THAT(Html(SilentSample()), Not(HasSubstr("Three axes")));
}

TEST(Report, SaysNothingOfNumbersThatAreNotThere) {
  const std::string html = Html(HostileSample());
  EXPECT_THAT(html, Not(HasSubstr(">nan")));
  EXPECT_THAT(html, Not(HasSubstr(" nan")));
}

TEST(WriteReport, ReplacesTheFileAndLeavesNothingElse) {
  const TemporaryFolder folder;
  WriteReport(AnalysisSample(), folder / "report.html", WithoutCharts());
  WriteReport(SilentSample(), folder / "report.html", WithoutCharts());
  EXPECT_EQ(ReadFile(folder / "report.html"), Html(SilentSample()));
  EXPECT_EQ(CountFiles(folder.path()), 1);
}

TEST(WriteReport, NamesTheFileThatCannotBeWritten) {
  const TemporaryFolder folder;
  try {
    WriteReport({}, folder / "absent/report.html", WithoutCharts());
    FAIL() << "wrote into a folder that is not there";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), HasSubstr("absent/report.html"));
  }
  fs::create_directory(folder / "report.html");
  EXPECT_THROW(WriteReport({}, folder / "report.html", WithoutCharts()), DataError);
  EXPECT_EQ(CountFiles(folder.path()), 1);
}

}  // namespace
}  // namespace gyrobench::presentation
