// A trace in words: said once, and within the line.
#include "cli/trace_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "base/measurement.h"
#include "cli/result_text.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Words as they follow each other, wherever lines end.
std::string Flat(const std::string& text) {
  std::istringstream stream(text);
  std::string flat;
  for (std::string word; stream >> word;) flat += (flat.empty() ? "" : " ") + word;
  return flat;
}

int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size())
    ++count;
  return count;
}

Terminal Narrow(int columns) {
  Terminal terminal;
  terminal.is_terminal = true;
  terminal.columns = columns;
  return terminal;
}

json Parameter(const std::string& name, double value, const std::string& unit) {
  return {{"name", name}, {"value", value}, {"unit", unit}, {"std_error", nullptr}};
}

json Ripple(double k) {
  return {{"id", "angle.ripple"},
          {"owner", "bench"},
          {"equation", "a sin(k phi) + b cos(k phi)"},
          {"cause", "steps of the motor, teeth of a gear, or lines of the encoder"},
          {"parameters", {Parameter("amplitude", k / 1000.0, "deg"), Parameter("k", k, "1/turn")}},
          {"p_value", 1e-20},
          {"rivals", json::array()},
          {"settled_by", ""}};
}

json Unseen(const std::string& id, const std::string& because, const std::string& by) {
  return {{"id", id}, {"because", because}, {"settled_by", by}};
}

json Channel(const std::string& gyro, const json& effects) {
  json channel = {{"gyro", gyro},
                  {"verdict", effects.empty() ? "none" : "partly_explained"},
                  {"baseline", {{"whitened_rms", 1.0}}},
                  {"effects", effects},
                  {"heldout_angle_rms_deg", {{"before", 0.62}, {"after", 0.15}}}};
  json& unseen = channel["unidentifiable"];
  for (int i = 0; i < 12; ++i)
    unseen.push_back(Unseen("scale.number_" + std::to_string(i), "there is no motion",
                            i % 2 == 0 ? "turn at six speeds" : "turn cold and hot"));
  const std::string own = gyro == "x" ? "0.3" : "0.4";
  unseen.push_back(
      Unseen("bias.g", "its bound, " + own + " deg/s/g, is beyond, 0.1", "hold poses"));
  channel["remarks"] = {"the site's latitude is not given", "remark of gyro " + gyro};
  return channel;
}

json ThreeAxes() {
  json ripples = json::array();
  for (const double k : {100.5, 200.25, 500.75, 900.125}) ripples.push_back(Ripple(k));
  return {{"channels",
           {Channel("x", json::array()), Channel("y", json::array()), Channel("z", ripples)}},
          {"inputs", {{{"file", "turns.csv"}, {"samples", 10}, {"duration_s", 1.0}}}},
          {"remarks", json::array()}};
}

TEST(TraceText, BeginsWithALineForEachAxisAndItsVerdict) {
  const auto lines = Lines(TraceText(ThreeAxes(), Terminal()));
  ASSERT_GT(lines.size(), 3u);
  EXPECT_EQ(lines[0], "Gyro x: nothing beyond the baseline");
  EXPECT_EQ(lines[1], "Gyro y: nothing beyond the baseline");
  EXPECT_THAT(lines[2], StartsWith("Gyro z: partly explained by angle.ripple (4 times); "));
}

TEST(TraceText, KeepsRivalsApartFromWhatBelongsTogether) {
  json trace = ThreeAxes();
  json& effects = trace["channels"][2]["effects"];
  effects = {effects[0], effects[1]};
  effects[1]["id"] = "angle.latency";
  effects[1]["rivals"] = {"angle.clock_drift"};
  EXPECT_THAT(Flat(TraceText(trace, Terminal())),
              HasSubstr("explained by angle.ripple; angle.latency or angle.clock_drift"));
}

TEST(TraceText, SaysEachReasonRemarkAndManoeuvreThatAllAxesShareOnce) {
  const std::string text = Flat(TraceText(ThreeAxes(), Terminal()));
  for (const char* once : {"there is no motion", "the site's latitude is not given",
                           "turn at six speeds", "turn cold and hot", "scale.number_7,"})
    EXPECT_EQ(Count(text, once), 1) << once;
  EXPECT_EQ(Count(text, "its bound is beyond"), 1);
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
  json trace = ThreeAxes();
  trace["inputs"][0]["duration_s"] = 600.0;
  json& noise = trace["channels"][2]["noise"];
  noise = {{"angle_random_walk_deg_sqrt_s", 0.005},
           {"bias_random_walk_deg_s_sqrt_s", 3e-9},
           {"reference_deg", 0.0}};
  const std::string hidden = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(hidden, HasSubstr("angle random walk 0.005 deg/sqrt(s)"));
  EXPECT_THAT(hidden, HasSubstr("bias random walk not seen the angle random walk hides"));
  EXPECT_THAT(hidden, Not(HasSubstr("3e-09")));
  EXPECT_THAT(hidden, Not(HasSubstr("reference noise 0")));
  noise["bias_random_walk_deg_s_sqrt_s"] = 1e-4;
  noise["reference_deg"] = 0.02;
  const std::string seen = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(seen, HasSubstr("bias random walk 0.0001 deg/s/sqrt(s)"));
  EXPECT_THAT(seen, HasSubstr("reference noise 0.02 deg"));
}

TEST(TraceText, SaysAReasonForTheAxesOfWhichItHolds) {
  json trace = ThreeAxes();
  trace["channels"][1]["unidentifiable"].clear();
  trace["channels"][2]["unidentifiable"].erase(0);
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
  const std::string wide = Flat(TraceSummary(ThreeAxes(), Terminal()));
  for (const int columns : {40, 72, 300})
    EXPECT_EQ(Flat(TraceSummary(ThreeAxes(), Narrow(columns))), wide);
}

TEST(TraceText, StaysWithinTheTerminalAndWithinAHundredColumnsWithoutOne) {
  for (const int columns : {60, 80, 99}) {
    for (const std::string& line : Lines(TraceText(ThreeAxes(), Narrow(columns))))
      EXPECT_LE(DisplayWidth(line), columns) << line;
  }
  for (const Terminal& terminal : {Terminal(), Narrow(400)}) {
    for (const std::string& line : Lines(TraceText(ThreeAxes(), terminal)))
      EXPECT_LE(DisplayWidth(line), 100) << line;
  }
}

TEST(TraceText, SaysWhatANonlinearityDoesAtTheLargestRateOfItsOwnAxis) {
  json trace = ThreeAxes();
  trace["channels"][2]["effects"] = {
      {{"id", "scale.cubic"}, {"parameters", {Parameter("c", 1e-6, "1/(deg/s)^2")}}}};
  const std::string text = TraceText(trace, Terminal(), {500.0, 500.0, 40.0});
  EXPECT_THAT(text, HasSubstr("0.16 % at 40 deg/s"));
  EXPECT_THAT(TraceText(trace, Terminal()), Not(HasSubstr("% at")));
  EXPECT_THAT(TraceText(trace, Terminal(), {500.0, 500.0, kMissing}), Not(HasSubstr("% at")));
}

TEST(TraceText, ShowsCurvesOfOneQuantityEachWithItsEndsAndWithoutErrors) {
  json trace = ThreeAxes();
  json& effects = trace["channels"][2]["effects"] = json::array();
  for (const double from : {25.5, 31.5}) {
    effects.push_back({{"id", "empirical(T)"},
                       {"equation", "0 below T = " + std::to_string(from)},
                       {"cause", "unknown"},
                       {"parameters",
                        {Parameter("change", 0.05, "deg/s"), Parameter("from", from, "degC"),
                         Parameter("to", from + 1.0, "degC")}}});
  }
  const std::string text = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(text,
              HasSubstr("change, deg/s from, degC to, degC (1) 0.05 25.5 26.5 (2) 0.05 31.5"));
  EXPECT_EQ(Count(text, "0 below T = "), 2);
  EXPECT_EQ(Count(text, "empirical(T): unknown"), 1);
  EXPECT_THAT(text, Not(HasSubstr("nan")));
}

TEST(TraceText, SaysAtWhichTemperatureAnOffsetHoldsThatDependsOnIt) {
  json trace = ThreeAxes();
  json& baseline = trace["channels"][0]["baseline"];
  baseline["parameters"] = {
      {{"name", "zero_rate_offset"}, {"value", 1.0}, {"unit", "deg/s"}, {"std_error", 0.1}}};
  baseline["reference_degC"] = nullptr;
  EXPECT_THAT(TraceText(trace, Terminal()), Not(HasSubstr("degC")));
  baseline["reference_degC"] = 31.25;
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("zero_rate_offset is that at 31.25 degC"));
}

TEST(TraceText, GivesNoVerdictOnAnAxisThatWasNotFitted) {
  json trace = ThreeAxes();
  trace["channels"][0]["baseline"]["whitened_rms"] = nullptr;
  EXPECT_THAT(TraceText(trace, Terminal()), StartsWith("Gyro x: not traced"));
}

json Rows(double diagonal, double off) {
  json rows = json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back({off, off, off});
    rows.back()[static_cast<std::size_t>(i)] = diagonal;
  }
  return rows;
}

TEST(TraceText, TabulatesTheThreeAxesToTheDigitsOfTheirErrors) {
  const json trace = {{"channels", json::array()},
                      {"vector",
                       {{"unit", "LSB"},
                        {"missing", json::array()},
                        {"matrix",
                         {{"m", Rows(1.0123456, -0.00234567)},
                          {"m_std_error", Rows(1e-5, 2e-6)},
                          {"a", Rows(0.0075, 1e-5)},
                          {"a_std_error", Rows(1e-7, 1e-7)}}},
                        {"split",
                         {{"scale", {1.01, 1.02, 1.03}},
                          {"scale_std_error", {1e-3, 1e-3, 1e-3}},
                          {"mount_deg", {0.5, nullptr, -90.25}},
                          {"mount_std_error_deg", {0.01, nullptr, 0.01}}}},
                        {"remarks", {"a remark"}}}}};
  const std::string text = Flat(TraceText(trace, Terminal()));
  EXPECT_THAT(text, HasSubstr("Three axes"));
  EXPECT_THAT(text, HasSubstr("M x 1.012346 ± 0.000010 -0.0023457 ± 0.0000020"));
  EXPECT_THAT(text, HasSubstr("scale factor 1.0100 ± 0.0010 1.0200 ± 0.0010"));
  EXPECT_THAT(text, HasSubstr("mounting 0.500 ± 0.010 - -90.250 ± 0.010 deg"));
  EXPECT_THAT(text, HasSubstr("a remark"));
}

TEST(TraceText, SaysWhyThereIsNoMatrix) {
  const json trace = {{"channels", json::array()},
                      {"vector", {{"missing", {"gyro x and y were not traced"}}}}};
  EXPECT_THAT(TraceText(trace, Terminal()), HasSubstr("no matrix: gyro x and y were not traced"));
}

// A scale factor beside which a nonlinearity is named is none that holds elsewhere.
TEST(ResultWithTrace, SaysOfWhichNumbersTheTraceNamesEffects) {
  const json result = {{"scale", {{{"axis", "z"}, {"alpha", 0.0076}, {"alpha_std_error", 1e-7}}}},
                       {"bias",
                        {{{"axis", "x"}, {"coefficients", {-132.0}}, {"std_errors", {0.3}}},
                         {{"axis", "z"}, {"coefficients", {-150.0}}, {"std_errors", {0.3}}}}}};
  const json trace = {
      {"channels",
       {{{"gyro", "x"}, {"effects", {{{"id", "bias.g_linear"}}, {{"id", "angle.latency"}}}}},
        {{"gyro", "z"}, {"effects", {{{"id", "scale.cubic"}}, {{"id", "scale.cubic"}}}}}}}};
  const std::string text = Flat(ResultText(WithTraceRemarks(result, trace), Narrow(100)));
  EXPECT_EQ(Count(text, "the trace names"), 2);
  EXPECT_THAT(text, HasSubstr("the trace names scale.cubic: alpha holds for the rates"));
  EXPECT_THAT(text, HasSubstr("x: the trace names bias.g_linear: this bias is the mean"));
  EXPECT_EQ(WithTraceRemarks(result, nullptr), result);
}

}  // namespace
}  // namespace gyrobench::cli
