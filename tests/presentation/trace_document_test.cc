// A trace in words: said once, and within the line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/measurement.h"
#include "presentation/sections.h"
#include "presentation/text_layout.h"
#include "tests/presentation/sample_content.h"
#include "tests/words.h"

namespace gyrobench::presentation {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

using calibration::ChannelTrace;
using calibration::ModelParameter;
using calibration::TracedEffect;
using calibration::TraceResult;

std::string TraceText(const TraceResult& trace, const Terminal& terminal) {
  return RenderText(TraceDocument(trace), terminal);
}

ModelParameter Parameter(const std::string& name, double value, const std::string& unit) {
  ModelParameter parameter;
  parameter.name = name;
  parameter.value = value;
  parameter.unit = unit;
  return parameter;
}

TracedEffect Ripple(double k) {
  TracedEffect ripple;
  ripple.id = "angle.ripple";
  ripple.owner = calibration::EffectOwner::kBench;
  ripple.equation = "a sin(k phi) + b cos(k phi)";
  ripple.cause = "steps of the motor, teeth of a gear, or lines of the encoder";
  ripple.parameters = {Parameter("amplitude", k / 1000.0, "deg"), Parameter("k", k, "1/turn")};
  ripple.p_value = 1e-20;
  return ripple;
}

ChannelTrace Channel(SensorAxis axis, const std::vector<TracedEffect>& effects) {
  ChannelTrace channel;
  channel.axis = axis;
  if (!effects.empty()) channel.verdict = calibration::Verdict::kPartlyExplained;
  channel.baseline.whitened_rms = 1.0;
  channel.effects = effects;
  channel.heldout_angle_rms_deg = {0.62, 0.15, {kMissing, kMissing}};
  for (int i = 0; i < 12; ++i)
    channel.unidentifiable.push_back({"scale.number_" + std::to_string(i), "there is no motion",
                                      i % 2 == 0 ? "turn at six speeds" : "turn cold and hot"});
  channel.unidentifiable.push_back({"bias.g", "its bound of " + GyroName(axis), "hold poses"});
  channel.unidentifiable.back().limit = {axis == SensorAxis::kX ? 0.3 : 0.4, 0.1, "deg/s/g"};
  channel.remarks = {"the site's latitude is not given", "remark of " + GyroName(axis)};
  return channel;
}

TraceResult ThreeAxes() {
  TraceResult trace;
  std::vector<TracedEffect> ripples;
  for (const double k : {100.5, 200.25, 500.75, 900.125}) ripples.push_back(Ripple(k));
  trace.channels = {Channel(SensorAxis::kX, {}), Channel(SensorAxis::kY, {}),
                    Channel(SensorAxis::kZ, ripples)};
  trace.inputs = {{"turns.csv", 10, 1.0, {}}};
  return trace;
}

TEST(TraceText, BeginsWithALineForEachAxisAndItsVerdict) {
  const auto lines = Lines(TraceText(ThreeAxes(), Terminal()));
  ASSERT_GT(lines.size(), 3u);
  EXPECT_EQ(lines[0], "Gyro x: nothing beyond the baseline");
  EXPECT_EQ(lines[1], "Gyro y: nothing beyond the baseline");
  EXPECT_THAT(lines[2], StartsWith("Gyro z: partly explained by angle.ripple (4 times); "));
}

TEST(TraceText, KeepsRivalsApartFromWhatBelongsTogether) {
  TraceResult trace = ThreeAxes();
  std::vector<TracedEffect>& effects = trace.channels[2].effects;
  effects.resize(2);
  effects[1].id = "angle.latency";
  effects[1].rivals = {"angle.clock_drift"};
  EXPECT_THAT(Flat(TraceText(trace, Terminal())),
              HasSubstr("explained by angle.ripple; angle.latency or angle.clock_drift"));
}

TEST(TraceText, SaysEachReasonRemarkAndManoeuvreThatAllAxesShareOnce) {
  const std::string text = Flat(TraceText(ThreeAxes(), Terminal()));
  for (const char* once : {"there is no motion", "the site's latitude is not given",
                           "turn at six speeds", "turn cold and hot", "scale.number_7,"})
    EXPECT_EQ(Count(text, once), 1) << once;
  EXPECT_EQ(Count(text, "its bound here is beyond the largest size of such parts"), 1);
  for (const char* gyro : {"x", "y", "z"})
    EXPECT_EQ(Count(text, std::string("! gyro ") + gyro + ": remark of gyro " + gyro), 1);
}

TEST(TraceText, PairsEachEffectThatWasNotToBeSeenWithItsManoeuvre) {
  const std::string text = Flat(TraceText(ThreeAxes(), Terminal()));
  std::string even, odd;
  for (int i = 0; i < 12; ++i) {
    std::string& list = i % 2 == 0 ? even : odd;
    list += (list.empty() ? "" : ", ") + ("scale.number_" + std::to_string(i));
  }
  EXPECT_THAT(text, HasSubstr(even + ": turn at six speeds"));
  EXPECT_THAT(text, HasSubstr(odd + ": turn cold and hot"));
  EXPECT_THAT(text, HasSubstr("bias.g: hold poses"));
}

// Likelihood that ends at a bound is no measurement.
TEST(TraceText, ShowsNoNoiseThatTheseDataCouldNotHaveShown) {
  TraceResult trace = ThreeAxes();
  trace.inputs[0].duration_s = 600.0;
  calibration::NoiseModel& noise = trace.channels[2].noise;
  noise = {0.005, 3e-9, 0.0};
  const std::string hidden = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(hidden, HasSubstr("angle random walk 0.005 deg/sqrt(s)"));
  EXPECT_THAT(hidden, HasSubstr("bias random walk not seen the angle random walk hides"));
  EXPECT_THAT(hidden, Not(HasSubstr("3e-09")));
  EXPECT_THAT(hidden, Not(HasSubstr("reference noise 0")));
  noise.bias_random_walk_deg_s_sqrt_s = 1e-4;
  noise.reference_deg = 0.02;
  const std::string seen = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(seen, HasSubstr("bias random walk 0.0001 deg/s/sqrt(s)"));
  EXPECT_THAT(seen, HasSubstr("reference noise 0.02 deg"));
}

TEST(TraceText, SaysAReasonForTheAxesOfWhichItHolds) {
  TraceResult trace = ThreeAxes();
  trace.channels[1].unidentifiable.clear();
  auto& of_z = trace.channels[2].unidentifiable;
  of_z.erase(of_z.begin());
  const std::string text = Flat(TraceText(trace, Terminal()));
  EXPECT_EQ(Count(text, "gyro x: there is no motion"), 1);
  EXPECT_EQ(Count(text, "gyro z: there is no motion"), 1);
  EXPECT_EQ(Count(text, "there is no motion"), 2);
}

TEST(TraceText, SaysOnceWhatEffectsOfOneIdShareAndEveryNumberOfThem) {
  const std::string text = Flat(TraceText(ThreeAxes(), Terminal()));
  EXPECT_EQ(Count(text, "a sin(k phi)"), 1);
  EXPECT_EQ(Count(text, "teeth of a gear"), 1);
  EXPECT_THAT(text, HasSubstr("amplitude, deg k, 1/turn (1) 0.1005 100.5 (2) 0.20025 200.25 (3) "
                              "0.50075 500.75 (4) 0.900125 900.125"));
}

TEST(TraceText, LeavesNoWordOutThatItBreaksLinesAt) {
  const std::string wide = Flat(RenderText(TraceSummary(ThreeAxes()), Terminal()));
  for (const int columns : {40, 72, 300})
    EXPECT_EQ(Flat(RenderText(TraceSummary(ThreeAxes()), OfColumns(columns))), wide);
}

TEST(TraceText, StaysWithinTheTerminalAndWithinAHundredColumnsWithoutOne) {
  for (const int columns : {60, 80, 99}) {
    for (const std::string& line : Lines(TraceText(ThreeAxes(), OfColumns(columns))))
      EXPECT_LE(DisplayWidth(line), columns) << line;
  }
  for (const Terminal& terminal : {Terminal(), OfColumns(400)}) {
    for (const std::string& line : Lines(TraceText(ThreeAxes(), terminal)))
      EXPECT_LE(DisplayWidth(line), 100) << line;
  }
}

TEST(TraceText, SaysWhatANonlinearityDoesAtTheLargestRateOfItsOwnAxis) {
  TraceResult trace = ThreeAxes();
  TracedEffect cubic;
  cubic.id = "scale.cubic";
  cubic.parameters = {Parameter("c", 1e-6, "1/(deg/s)^2")};
  trace.channels[2].effects = {cubic};
  for (ChannelTrace& channel : trace.channels)
    channel.curves.rate_error_by_rate_deg_s.x = {-500.0, 0.0};
  trace.channels[2].curves.rate_error_by_rate_deg_s.x = {-40.0, 0.0, 39.0};
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("0.16 % at 40 deg/s"));
  trace.channels[2].curves = {};
  EXPECT_THAT(TraceText(trace, Terminal()), Not(HasSubstr("% at")));
}

TEST(TraceText, ShowsCurvesOfOneQuantityEachWithItsEndsAndWithoutErrors) {
  TraceResult trace = ThreeAxes();
  std::vector<TracedEffect>& effects = trace.channels[2].effects;
  effects.clear();
  for (const double from : {25.5, 31.5}) {
    TracedEffect curve;
    curve.id = "empirical(T)";
    curve.equation = "0 below T = " + std::to_string(from);
    curve.cause = "unknown";
    curve.parameters = {Parameter("change", 0.05, "deg/s"), Parameter("from", from, "degC"),
                        Parameter("to", from + 1.0, "degC")};
    effects.push_back(curve);
  }
  const std::string text = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(text,
              HasSubstr("change, deg/s from, degC to, degC (1) 0.05 25.5 26.5 (2) 0.05 31.5"));
  EXPECT_EQ(Count(text, "0 below T = "), 2);
  EXPECT_EQ(Count(text, "empirical(T): unknown; from the catalogue"), 1);
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

TEST(TraceText, SaysAtWhichTemperatureAnOffsetHoldsThatDependsOnIt) {
  TraceResult trace = ThreeAxes();
  auto& baseline = trace.channels[0].baseline;
  baseline.parameters = {Parameter("zero_rate_offset", 1.0, "deg/s")};
  EXPECT_THAT(TraceText(trace, Terminal()), Not(HasSubstr("degC")));
  baseline.reference_degC = 31.25;
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("zero_rate_offset is that at 31.25 degC"));
}

TEST(TraceText, GivesNoVerdictOnAnAxisThatWasNotFitted) {
  TraceResult trace = ThreeAxes();
  trace.channels[0].baseline.whitened_rms = kMissing;
  EXPECT_THAT(TraceText(trace, Terminal()), StartsWith("Gyro x: not traced"));
}

TEST(TraceText, ComparesTheErrorBeforeAndAfterWithItsInterval) {
  TraceResult trace = ThreeAxes();
  calibration::HeldOut& angle = trace.channels[2].heldout_angle_rms_deg;
  angle.reduction_ci95 = {0.712, 0.763};
  EXPECT_THAT(
      Flat(TraceText(trace, Terminal())),
      HasSubstr("angle error, held out 0.620 → 0.150 deg 75.8 % less (95 %: 71.2 to 76.3 % less); "
                "windows of 10 s, effects chosen and fitted without them"));
  angle.reduction_ci95 = {-0.08, 0.03};
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("(95 %: 8.0 % more to 3.0 % less)"));
  angle.reduction_ci95 = {-0.08, -0.03};
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("(95 %: 3.0 to 8.0 % more)"));
}

TEST(TraceText, SaysInItsFirstLinesWhatHeldOutDataDoNotConfirm) {
  TraceResult trace = ThreeAxes();
  EXPECT_THAT(TraceText(trace, Terminal()), Not(HasSubstr("does not confirm")));
  calibration::HeldOut& angle = trace.channels[2].heldout_angle_rms_deg;
  angle.after = angle.before;
  EXPECT_THAT(
      Flat(TraceText(trace, Terminal())),
      HasSubstr("angle error of held-out data 0.620 → 0.620 deg, which does not confirm it"));
}

TEST(TraceText, SaysWhereTheFirstDefectOfEachKindIs) {
  TraceResult trace = ThreeAxes();
  trace.inputs[0].defects = {{"gap", 3, 1.25, "line 57"}, {"no_gyro", 2, kMissing, "line 8"}};
  const std::string text = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(text, HasSubstr("3 gap, first at 1.250 s, line 57; 2 no_gyro, first line 8"));
}

TEST(TraceText, NamesTheOwnerOnlyWhereTheRivalsAreItsAsWell) {
  TraceResult trace = ThreeAxes();
  TracedEffect play = Ripple(1.0);
  play.id = "angle.backlash";
  play.rivals = {"angle.ripple"};
  trace.channels[2].effects = {play};
  EXPECT_THAT(NamesOfEffects(trace.channels[2], true).Plain(), HasSubstr("the bench's"));
  trace.channels[2].effects[0].rivals = {"bias.hysteresis"};
  EXPECT_THAT(NamesOfEffects(trace.channels[2], true).Plain(), Not(HasSubstr("bench")));
}

TEST(TraceText, SaysThatNothingWasAddedWhereNothingWas) {
  TraceResult trace = ThreeAxes();
  const std::string text = TraceText(trace, Terminal());
  EXPECT_EQ(Count(text, "Nothing was added"), 2);
  trace.channels[0].effects = trace.channels[1].effects = trace.channels[2].effects;
  EXPECT_THAT(TraceText(trace, Terminal()), Not(HasSubstr("Nothing was added")));
}

TEST(TraceText, SaysWhetherTheRestIsWhiteBesideWhatIsFoundInIt) {
  TraceResult trace = ThreeAxes();
  trace.channels.resize(1);
  trace.channels[0].remaining = {true, {{"covariate", "T", 3.1e-6, "it follows T"}}};
  EXPECT_THAT(Flat(TraceText(trace, Terminal())),
              HasSubstr("the rest is white, but: - it follows T (p = 3.1e-06)"));
  trace.channels[0].remaining.white = false;
  EXPECT_THAT(Flat(TraceText(trace, Terminal())),
              HasSubstr("the rest is not white: - it follows T (p = 3.1e-06)"));
}

TEST(TraceText, SaysWhatEachOfSeveralEffectsWasChosenOn) {
  TraceResult trace = ThreeAxes();
  std::vector<TracedEffect>& effects = trace.channels[2].effects;
  EXPECT_EQ(Count(Flat(TraceText(trace, Terminal())), "Chosen on: all data only"), 1);
  effects[0].chosen_on = calibration::ChosenOn::kTrainingPart;
  EXPECT_THAT(Flat(TraceText(trace, Terminal())), HasSubstr("Chosen on: (1) two thirds"));
}

TEST(TraceText, NamesNoFileOfAnInputThatHasNone) {
  TraceResult trace = ThreeAxes();
  trace.inputs[0].file.clear();
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("\n10 samples in 1.00 s"));
}

Matrix3 Rows(double diagonal, double off) {
  Matrix3 rows;
  for (std::size_t i = 0; i < 3; ++i) {
    rows[i] = {off, off, off};
    rows[i][i] = diagonal;
  }
  return rows;
}

TEST(TraceText, TabulatesTheThreeAxesToTheDigitsOfTheirErrors) {
  TraceResult trace;
  calibration::VectorCalibration& vector = trace.vector;
  vector.unit = "LSB";
  vector.matrix.emplace();
  vector.matrix->m = Rows(1.0123456, -0.00234567);
  vector.matrix->m_std_error = Rows(1e-5, 2e-6);
  vector.matrix->a = Rows(0.0075, 1e-5);
  vector.matrix->a_std_error = Rows(1e-7, 1e-7);
  vector.split.emplace();
  vector.split->scale = {1.01, 1.02, 1.03};
  vector.split->scale_std_error = {1e-3, 1e-3, 1e-3};
  vector.split->mount_deg = {0.5, kMissing, -90.25};
  vector.split->mount_std_error_deg = {0.01, kMissing, 0.01};
  vector.remarks = {"a remark"};
  const std::string text = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(text, HasSubstr("Three axes"));
  EXPECT_THAT(text, HasSubstr("M x 1.012346 ± 0.000010 -0.0023457 ± 0.0000020"));
  EXPECT_THAT(text, HasSubstr("scale factor 1.0100 ± 0.0010 1.0200 ± 0.0010"));
  EXPECT_THAT(text,
              HasSubstr("about x about y about z mounting 0.500 ± 0.010 - -90.250 ± 0.010 deg"));
  EXPECT_THAT(text, HasSubstr("a remark"));
  // Where three columns have no room they stand below each other, and what is not known is left out.
  const std::string narrow = Flat(TraceText(trace, OfColumns(60)));
  EXPECT_EQ(Count(narrow, "scale factor"), 3);
  EXPECT_THAT(Flat(TraceText(trace, OfColumns(40))), HasSubstr("about x mounting 0.500 ± 0.010 deg "
                                                               "about z mounting -90.250"));
  // Nor is there room for one with its name and unit.
  EXPECT_THAT(TraceText(trace, OfColumns(32)),
              HasSubstr("    A x, deg/s per LSB\n      x: 0.00750000 ± 0.00000010\n      y: "));
}

TEST(TraceText, SaysWhyThereIsNoMatrix) {
  TraceResult trace;
  trace.vector.missing = {"gyro x and y were not traced"};
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("no matrix: gyro x and y were not traced"));
}

// What was never filled in is no reason to fail, and no number.
TEST(TraceText, ShowsWhatThereIsOfATraceThatIsNotWhole) {
  EXPECT_EQ(RenderText(TraceSummary({}), Terminal()), "");
  TraceResult trace;
  trace.channels.resize(1);
  trace.channels[0].axis = SensorAxis::kX;
  trace.channels[0].verdict = calibration::Verdict::kPartlyExplained;
  trace.channels[0].effects.resize(1);
  trace.channels[0].effects[0].id = "angle.latency";
  trace.channels[0].effects[0].rivals = {"angle.clock_drift"};
  const std::string text = TraceText(trace, Terminal());
  EXPECT_THAT(text, HasSubstr("Gyro x: partly explained"));
  EXPECT_THAT(text, HasSubstr("or angle.clock_drift"));
  EXPECT_THAT(text, Not(HasSubstr("nan")));
  EXPECT_THAT(RenderText(TraceSummary(trace), Terminal()),
              HasSubstr("gyro x: partly explained by angle.latency or angle.clock_drift"));
}

}  // namespace
}  // namespace gyrobench::presentation
