// `gyrobench trace` and `report` on tables: the built program is run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>
#include <sstream>

#include "tests/cli/child_process.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Turns there and back at three speeds; the supply swings and takes the offset with it.
std::string Turns(double per_volt_deg_s, const std::string& sensor, unsigned seed,
                  double scale = 1.01) {
  std::ostringstream table;
  table.precision(9);
  table << "# gyro_lsb_per_deg_s = 131\n# sensor = " << sensor
        << "\nt_s,gyro_z_lsb,ref_angle_z_deg,supply_v\n";
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, 3.0);
  const double dt_s = 0.01;
  double angle_deg = 0.0, before_deg_s = 0.0;
  for (int i = 0; i < 30000; ++i) {
    const double t = i * dt_s;
    const int turn = static_cast<int>(t / 5.0);
    const double speed = std::fmod(t, 5.0) < 2.0 ? 0.0 : 6.0 * (1 + turn % 3);
    const double rate = turn % 2 == 0 ? speed : -speed;
    angle_deg += 0.5 * (rate + before_deg_s) * dt_s;
    before_deg_s = rate;
    const double supply = 3.3 + 0.2 * std::sin(2.0 * std::numbers::pi * t / 37.0);
    const double xi = 131.0 * (scale * rate + 0.3 + per_volt_deg_s * (supply - 3.3));
    table << t << ',' << std::round(xi + noise(random)) << ',' << angle_deg << ',' << supply
          << '\n';
  }
  return table.str();
}

json TraceOf(const std::filesystem::path& table) {
  const Finished finished = Gyrobench({"trace", table, "--json"});
  EXPECT_EQ(finished.status, 0) << finished.err;
  return json::parse(finished.out);
}

class Trace : public testing::Test {
 protected:
  TemporaryFolder folder_;
};

TEST_F(Trace, NamesTheColumnThatTheResidualFollowsInJsonAndInWords) {
  const auto table = folder_.Write("turns.csv", Turns(0.5, "A", 1));
  const json trace = TraceOf(table);
  EXPECT_EQ(trace.at("format"), "gyrobench.trace/1");
  EXPECT_EQ(trace.at("inputs").at(0).at("samples"), 30000);
  const json& channel = trace.at("channels").at(0);
  EXPECT_EQ(channel.at("gyro"), "z");
  EXPECT_EQ(channel.at("verdict"), "explained");
  EXPECT_EQ(channel.at("effects").at(0).at("id"), "bias.of(supply_v)");
  const Finished text = Gyrobench({"trace", table});
  EXPECT_THAT(text.out, testing::StartsWith("Gyro z: explained"));
  EXPECT_THAT(text.out, HasSubstr("bias.of(supply_v)"));
  EXPECT_THAT(text.out, Not(testing::ContainsRegex("[^a-z]nan[^a-z]")));
}

TEST_F(Trace, GivesTheSameToTheLastDigitWhenAskedAgain) {
  const auto table = folder_.Write("turns.csv", Turns(0.1, "A", 3));
  EXPECT_EQ(TraceOf(table), TraceOf(table));
}

TEST_F(Trace, WritesACalibrationWithTheHashesOfItsFilesThatApplyTakes) {
  const auto table = folder_.Write("turns.csv", Turns(0.5, "A", 1));
  const Finished traced = Gyrobench({"trace", table, "-q", "--calibration", folder_ / "cal.json"});
  ASSERT_EQ(traced.status, 0) << traced.err;
  EXPECT_EQ(traced.out, "");
  std::ifstream in(folder_ / "cal.json");
  const json calibration = json::parse(in);
  EXPECT_EQ(calibration.at("sensor"), "A");
  EXPECT_EQ(calibration.at("inputs").at(0).at("file"), "turns.csv");
  EXPECT_EQ(calibration.at("channels").at(0).at("terms").at(0).at("chosen_on"),
            TraceOf(table).at("channels").at(0).at("effects").at(0).at("chosen_on"));
  const Finished sum = RunToEnd({"sha256sum", table});
  EXPECT_EQ(calibration.at("inputs").at(0).at("sha256"), sum.out.substr(0, 64));
  const auto other = folder_.Write("other.csv", Turns(0.5, "A", 2));
  const Finished applied =
      Gyrobench({"apply", folder_ / "cal.json", other, "-o", folder_ / "corrected.csv"});
  EXPECT_EQ(applied.status, 0) << applied.err;
  // What was explained is gone: what is left of it is below what can be seen.
  const json again = TraceOf(folder_ / "corrected.csv");
  EXPECT_EQ(again.at("channels").at(0).at("verdict"), "none") << again.dump(2);
}

// Raw counts of an unsigned converter, from the table of the trace and from one that says nothing.
TEST_F(Trace, WritesTheCountOfZeroThatApplyTakesOffAgain) {
  std::istringstream turns(Turns(0.0, "A", 1));
  std::string rows, line;
  while (std::getline(turns, line)) {
    const std::size_t from = line.find(',') + 1, to = line.find(',', from);
    if (!line.starts_with('#') && !line.starts_with('t'))
      line.replace(from, to - from,
                   std::to_string(32768 + std::stoi(line.substr(from, to - from))));
    rows += line + '\n';
  }
  const auto said = folder_.Write("said.csv", "# gyro_lsb_zero = 32768\n" + rows);
  const auto silent = folder_.Write("silent.csv", rows);
  const std::string calibration = folder_ / "cal.json";
  ASSERT_EQ(Gyrobench({"trace", said, "-q", "--calibration", calibration}).status, 0);
  std::ifstream in(calibration);
  EXPECT_EQ(json::parse(in).at("gyro_lsb_zero"), 32768.0);
  const auto applied = [&](const std::filesystem::path& table, const char* out) {
    const Finished finished = Gyrobench({"apply", calibration, table, "-o", folder_ / out});
    EXPECT_EQ(finished.status, 0) << finished.err;
    std::ifstream corrected(folder_ / out);
    const std::string text(std::istreambuf_iterator<char>(corrected), {});
    return std::pair(finished.out, text.substr(text.find("t_s,")));
  };
  const auto with_key = applied(said, "a.csv"), without_key = applied(silent, "b.csv");
  EXPECT_EQ(with_key.second, without_key.second);
  EXPECT_THAT(with_key.first, Not(HasSubstr("counts less")));
  EXPECT_THAT(without_key.first, HasSubstr("counts less 32768"));
}

TEST_F(Trace, TakesManyRunsOfOneSensorAsOneProblemAndRefusesTwoSensors) {
  const auto a = folder_.Write("a.csv", Turns(0.5, "A", 1));
  const auto b = folder_.Write("b.csv", Turns(0.5, "A", 2));
  const auto other = folder_.Write("other.csv", Turns(0.5, "B", 3));
  const Finished both = Gyrobench({"trace", a, b, "--json"});
  ASSERT_EQ(both.status, 0) << both.err;
  EXPECT_EQ(json::parse(both.out).at("inputs").size(), 2u);
  EXPECT_EQ(json::parse(both.out).at("channels").size(), 1u);
  const Finished mixed = Gyrobench({"trace", a, other});
  EXPECT_EQ(mixed.status, 1);
  EXPECT_THAT(mixed.err, HasSubstr("one sensor"));
}

TEST_F(Trace, SaysWhenRunsFitApartAndNotTogether) {
  const auto a = folder_.Write("a.csv", Turns(0.5, "A", 1));
  const auto b = folder_.Write("b.csv", Turns(0.5, "A", 2));
  const auto changed = folder_.Write("changed.csv", Turns(0.5, "A", 2, 1.03));
  const std::string words = "together the inputs fit worse than each alone";
  EXPECT_THAT(Gyrobench({"trace", a, b}).out, Not(HasSubstr(words)));
  EXPECT_THAT(Gyrobench({"trace", a, changed, "--json"}).out, HasSubstr(words));
}

TEST_F(Trace, WritesAReportWhereAskedTo) {
  const auto table = folder_.Write("turns.csv", Turns(0.5, "A", 1));
  ASSERT_EQ(Gyrobench({"trace", table, "--report", folder_ / "a.html"}).status, 0);
  ASSERT_EQ(Gyrobench({"report", table, "-o", folder_ / "b.html"}).status, 0);
  for (const char* name : {"a.html", "b.html"}) {
    std::ifstream in(folder_ / name);
    const std::string page(std::istreambuf_iterator<char>(in), {});
    EXPECT_THAT(page, HasSubstr("bias.of(supply_v)")) << name;
    EXPECT_THAT(page, HasSubstr("turns.csv"));
  }
  EXPECT_EQ(Gyrobench({"report", table}).status, 2);  // a table has no place for a report
}

// Nothing of the data is looked at before it is known that the result can be written.
TEST_F(Trace, ChecksWhatItWillWriteBeforeItReads) {
  const auto bad = folder_.Write("bad.csv", "no table\n");
  folder_.Write("a-file", "");
  const auto refusal = [&](const std::string& option, const std::string& target) {
    const Finished finished = Gyrobench({"trace", bad, option, target});
    EXPECT_NE(finished.status, 0);
    EXPECT_THAT(finished.err, Not(HasSubstr("no measurement table"))) << target;
    return finished.err;
  };
  for (const char* option : {"--calibration", "--report"}) {
    EXPECT_THAT(refusal(option, folder_ / "absent/out"), HasSubstr("there is no folder"));
    EXPECT_THAT(refusal(option, folder_ / "a-file/out"), HasSubstr("there is no folder"));
    EXPECT_THAT(refusal(option, folder_ / "."), HasSubstr("that is a folder"));
    EXPECT_THAT(refusal(option, "/dev/null"), HasSubstr("plain file"));
    EXPECT_THAT(refusal(option, bad), HasSubstr("a file that is read"));
    if (geteuid() == 0) continue;  // who may write everywhere
    EXPECT_THAT(refusal(option, "/proc/out"), HasSubstr("may not be written"));
  }
  const std::string both = folder_ / "both";
  EXPECT_EQ(Gyrobench({"trace", bad, "--calibration", both, "--report", both}).status, 2);
}

TEST_F(Trace, SaysThatAFileWasReplaced) {
  const auto table = folder_.Write("turns.csv", Turns(0.5, "A", 1));
  const std::vector<std::string> command = {"trace", table, "--calibration", folder_ / "cal.json"};
  EXPECT_THAT(Gyrobench(command).out, Not(HasSubstr("replaces")));
  EXPECT_THAT(Gyrobench(command).out, HasSubstr("cal.json (replaces the file of that name)"));
}

// The model of a sensor in LSB needs to know what an LSB is.
TEST_F(Trace, WithoutASensitivityTakesItFromTurnsAndSaysSoAndRefusesRest) {
  std::string turns = Turns(0.0, "A", 1);
  turns.erase(0, turns.find('\n') + 1);
  const Finished traced = Gyrobench({"trace", folder_.Write("turns.csv", turns), "--json"});
  ASSERT_EQ(traced.status, 0) << traced.err;
  const std::string remarks = json::parse(traced.out).at("channels").at(0).at("remarks").dump();
  EXPECT_THAT(remarks, HasSubstr("LSB per deg/s is taken from these data"));
  EXPECT_THAT(remarks, HasSubstr("gyro_lsb_per_deg_s"));
  std::string rest = "t_s,gyro_z_lsb\n";
  for (int i = 0; i < 6000; ++i)
    rest += std::to_string(0.01 * i) + "," + std::to_string(60 + i % 5) + "\n";
  const Finished refused = Gyrobench({"trace", folder_.Write("rest.csv", rest)});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("sensitivity is not given"));
  EXPECT_THAT(refused.err, HasSubstr("gyrobench hold"));
  EXPECT_THAT(refused.err, HasSubstr("gyro_lsb_per_deg_s"));
}

TEST_F(Trace, ReportsBadFilesByNameAndEndsAsAFailure) {
  const std::string report = folder_ / "report.html";
  for (const char* command : {"trace", "report"}) {
    const auto fails = [&](const std::filesystem::path& file, const char* says) {
      std::vector<std::string> arguments = {command, file};
      if (arguments.front() == "report") arguments.insert(arguments.end(), {"-o", report});
      const Finished finished = Gyrobench(arguments);
      EXPECT_EQ(finished.status, 1) << command;
      EXPECT_THAT(finished.err, HasSubstr(says)) << command;
      EXPECT_EQ(finished.out, "");
    };
    fails(folder_ / "absent.csv", "absent.csv");
    fails(folder_.Write("no-gyro.csv", "t_s,temp_degC\n0,1\n"), "no column of the gyro");
    fails(folder_.Write("nan.csv", "t_s,gyro_z_lsb\n0,nan\n1,nan\n"), "nan.csv");
    fails(folder_.Write("empty.csv", "t_s,gyro_z_lsb\n"), "empty.csv");
  }
  EXPECT_EQ(Gyrobench({"trace"}).status, 2);
}

// Files are read side by side; which of them ends first is no matter.
TEST_F(Trace, OfSeveralBadFilesComplainsOfTheFirst) {
  const std::string good = folder_.Write("good.csv", Turns(0.0, "unit-7", 1));
  const std::string bad = "t_s,temp_degC\n0,1\n";
  std::string long_head;
  for (int i = 0; i < 20000; ++i) long_head += "# a line of the head that takes its time\n";
  const std::string late = folder_.Write("late.csv", long_head + bad);
  const std::string early = folder_.Write("early.csv", bad);
  for (int again = 0; again < 5; ++again) {
    EXPECT_THAT(Gyrobench({"trace", good, late, early, early}).err,
                AllOf(HasSubstr("late.csv"), Not(HasSubstr("early.csv"))));
    EXPECT_THAT(Gyrobench({"trace", late, early, good}).err,
                AllOf(HasSubstr("late.csv"), Not(HasSubstr("early.csv"))));
    EXPECT_THAT(Gyrobench({"trace", early, late, good}).err,
                AllOf(HasSubstr("early.csv"), Not(HasSubstr("late.csv"))));
  }
}

// One table has the turns of the shaft. Together they give a factor that no mistake has; alone the
// table that is wrong shows which, and its own gear says why.
TEST_F(Trace, OfSeveralInputsNamesTheOneWhoseScaleCannotBeAndItsOwnCause) {
  const auto good = folder_.Write("good.csv", Turns(0.0, "A", 1));
  std::istringstream turns(Turns(0.0, "A", 2));
  std::string line, of_the_shaft = "# gear_ratio = 40\n";
  while (std::getline(turns, line)) {
    const std::size_t from = line.find(',', line.find(',') + 1) + 1, to = line.rfind(',');
    if (!line.starts_with('#') && !line.starts_with('t'))
      line.replace(from, to - from, std::to_string(40.0 * std::stod(line.substr(from, to - from))));
    of_the_shaft += line + '\n';
  }
  const auto wrong = folder_.Write("wrong.csv", of_the_shaft);
  for (const auto& [first, second] : {std::pair(good, wrong), std::pair(wrong, good)}) {
    const Finished finished = Gyrobench({"trace", first, second, "--json"});
    EXPECT_EQ(finished.status, 1);
    EXPECT_THAT(finished.err, AllOf(HasSubstr("wrong.csv: this result cannot be"),
                                    HasSubstr("the factor is the gear ratio"),
                                    Not(HasSubstr("good.csv: this result cannot be"))));
    EXPECT_THAT(json::parse(finished.out).at("remarks").at(0).get<std::string>(),
                HasSubstr("wrong.csv: this result cannot be"));
  }
}

// The scale factor that comes of two clocks is no clue to anything else.
TEST_F(Trace, OfClocksNotStartedTogetherLooksForNoOtherCause) {
  std::istringstream turns(Turns(0.0, "A", 1, 1.5));
  std::vector<std::array<std::string, 4>> rows;
  std::string head, line;
  while (std::getline(turns, line)) {
    if (line.starts_with('#') || line.starts_with('t')) {
      head += line + '\n';
      continue;
    }
    std::istringstream cells(line);
    auto& row = rows.emplace_back();
    for (std::string& cell : row) std::getline(cells, cell, ',');
  }
  constexpr std::size_t kLate = 50;  // half a second
  std::string late = head;
  for (std::size_t i = kLate; i < rows.size(); ++i)
    late += rows[i][0] + ',' + rows[i][1] + ',' + rows[i - kLate][2] + ',' + rows[i][3] + '\n';
  const auto table = folder_.Write("late.csv", late);
  for (const char* command : {"trace", "analyze"}) {
    const Finished finished = Gyrobench({command, table, "--json"});
    EXPECT_EQ(finished.status, 1) << command << finished.err;
    EXPECT_THAT(finished.err, HasSubstr("were probably not started together")) << command;
    EXPECT_THAT(finished.out, HasSubstr("were probably not started together")) << command;
    EXPECT_THAT(finished.out, Not(HasSubstr("was expected of any part"))) << command;
  }
  const json traced = json::parse(Gyrobench({"trace", table, "--json"}).out);
  EXPECT_EQ(traced.at("channels").at(0).at("verdict"), "cannot_be");
  const Finished refused = Gyrobench({"trace", table, "-q", "--calibration", folder_ / "cal.json"});
  EXPECT_EQ(refused.status, 1);
  EXPECT_THAT(refused.err, HasSubstr("were probably not started together"));
}

// A script that goes by the status must not take "nothing was looked at" for "nothing is there".
TEST_F(Trace, OfTooLittleDataFailsAndSaysWhyInJsonAsWell) {
  std::string table = "t_s,gyro_z_deg_s,ref_angle_z_deg\n";
  for (int i = 0; i < 300; ++i)
    table += std::to_string(i * 0.01) + "," + std::to_string(0.1 + 1e-3 * (i % 7)) + ",5\n";
  const auto file = folder_.Write("still.csv", table);
  const auto calibration = folder_ / "cal.json", report = folder_ / "report.html";
  const Finished finished =
      Gyrobench({"trace", file, "--json", "--calibration", calibration, "--report", report});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("no axis could be traced"));
  EXPECT_THAT(finished.err, HasSubstr("s of usable data"));
  const json channel = json::parse(finished.out).at("channels").at(0);
  EXPECT_TRUE(channel.at("effects").empty());
  EXPECT_TRUE(channel.at("baseline").at("whitened_rms").is_null());
  EXPECT_FALSE(std::filesystem::exists(calibration));
  EXPECT_TRUE(std::filesystem::exists(report));
}

TEST_F(Trace, OfOneAxisOutOfTwoIsDoneAndTheOtherHasARemark) {
  std::istringstream turns(Turns(0.0, "A", 1));
  std::string table, line;
  for (int i = 0; std::getline(turns, line); ++i) {
    const bool head = line.starts_with('#'), names = line.starts_with('t');
    table += line + (head      ? ""
                     : names   ? ",gyro_x_lsb"
                     : i < 300 ? "," + std::to_string(i % 5)
                               : ",");
    table += '\n';
  }
  const json trace = TraceOf(folder_.Write("one.csv", table));
  EXPECT_TRUE(trace.at("channels").at(0).at("baseline").at("whitened_rms").is_null());
  EXPECT_THAT(trace.at("channels").at(0).at("remarks").dump(), HasSubstr("not traced"));
  EXPECT_TRUE(trace.at("channels").at(1).at("baseline").at("whitened_rms").is_number());
}

// The certificate of the reference enters the error of the scale factor as a relative variance of
// its own, next to that of the fit; and where there is none, the result says so.
TEST_F(Trace, CarriesTheReferencesOwnErrorFromTheHeadOfTheTable) {
  const std::string turns = Turns(0.5, "A", 1);
  const auto table = folder_.Write("said.csv", "# ref_scale_uncertainty = 0.002\n" + turns);
  const json trace = TraceOf(table);
  const auto scale_of = [](const json& one) -> json {
    for (const json& parameter : one.at("channels").at(0).at("baseline").at("parameters"))
      if (parameter.at("name") == "scale_factor") return parameter;
    return {};
  };
  const json scale = scale_of(trace);
  const double alone = scale.at("statistical_std_error"), value = scale.at("value");
  EXPECT_NEAR(scale.at("std_error").get<double>(), std::hypot(alone, 0.002 * value), 1e-12);
  EXPECT_NEAR(trace.at("reference_error").at("relative_std_uncertainty").get<double>(), 0.002,
              1e-12);
  EXPECT_THAT(Gyrobench({"trace", table}).out, HasSubstr("of the fit alone"));

  const auto silent = folder_.Write("silent.csv", turns);
  const json relative = TraceOf(silent);
  EXPECT_EQ(scale_of(relative).at("std_error").get<double>(), alone);
  EXPECT_TRUE(relative.at("reference_error").at("relative_std_uncertainty").is_null());
  EXPECT_THAT(relative.at("reference_error").at("says").get<std::string>(),
              HasSubstr("relative to the reference"));
  EXPECT_THAT(Gyrobench({"trace", silent}).out, HasSubstr("nothing is said of the reference"));

  const auto both = folder_ / "both.json";
  ASSERT_EQ(
      Gyrobench({"trace", table, "-q", "--calibration", both, "--report", folder_ / "said.html"})
          .status,
      0);
  std::ifstream in(both);
  const json calibration = json::parse(in);
  EXPECT_NEAR(calibration.at("channels").at(0).at("m_row_std_error").at(2).get<double>(),
              0.002 * value, 0.0002 * value);
  EXPECT_THAT(calibration.at("configuration").at("reference_error").get<std::string>(),
              HasSubstr("own uncertainty"));
  std::ifstream page(folder_ / "said.html");
  EXPECT_THAT(std::string(std::istreambuf_iterator<char>(page), {}), HasSubstr("own uncertainty"));
}

TEST_F(Trace, AndAnalyzeCarriesItTooAndSaysWhereNothingIsSaid) {
  const std::string turns = Turns(0.0, "A", 1);
  const auto said = folder_.Write("said.csv", "# ref_scale_uncertainty = 0.002\n" + turns);
  const auto silent = folder_.Write("silent.csv", turns);
  const auto analyze = [](const std::filesystem::path& table) {
    return json::parse(Gyrobench({"analyze", table, "--json"}).out);
  };
  const json with = analyze(said).at("scale").at(0), without = analyze(silent).at("scale").at(0);
  const double alone = with.at("alpha_statistical_std_error"), alpha = with.at("alpha");
  EXPECT_EQ(without.at("alpha_std_error").get<double>(), alone);
  EXPECT_TRUE(without.at("reference_uncertainty").is_null());
  EXPECT_NEAR(with.at("alpha_std_error").get<double>(), std::hypot(alone, 0.002 * alpha),
              1e-9 * alpha);
  EXPECT_THAT(Gyrobench({"analyze", silent}).out, HasSubstr("nothing is said of the reference"));
  EXPECT_THAT(Gyrobench({"analyze", said}).out, Not(HasSubstr("nothing is said of the reference")));
}

TEST_F(Trace, NamesTablesThatOverlapWithinAPowerOnByFileAndLine) {
  const std::string power_on = "# power_on = 7\n";
  const auto a = folder_.Write("a.csv", power_on + Turns(0.5, "A", 1));
  const auto b = folder_.Write("b.csv", "# a remark\n" + power_on + Turns(0.5, "A", 2));
  for (const char* command : {"trace", "analyze"}) {
    for (const auto& [first, second] : {std::pair(a, b), std::pair(b, a)}) {
      const Finished finished = Gyrobench({command, first, second});
      EXPECT_EQ(finished.status, 1) << command;
      EXPECT_THAT(finished.err, HasSubstr("b.csv:2: power_on = 7")) << command;
      EXPECT_THAT(finished.err, HasSubstr("a.csv:1")) << command;
    }
  }
}

}  // namespace
}  // namespace gyrobench::cli
