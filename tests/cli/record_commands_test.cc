// Commands on what is recorded: no daemon, no LCM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "gyrobench/gyro_t.hpp"
#include "gyrobench/run_t.hpp"
#include "presentation/number.h"
#include "recording/event_log.h"
#include "tests/cli/child_process.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

constexpr double kAlpha = 0.0076;  // deg/s per LSB of the made-up sensor

// 40 turns of 9 deg from stop to stop, 2 s of rest between, noise of 3 LSB a sample.
std::string TurnTable() {
  std::ostringstream table;
  table.precision(9);
  table << "# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb,ref_angle_z_deg\n";
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0.0, 3.0);
  const double dt_s = 0.01, rate_deg_s = 9.0;
  double angle_deg = 0.0;
  for (int i = 0; i < 40 * 300; ++i) {
    const bool turning = i % 300 >= 200;
    const double rate = turning ? rate_deg_s : 0.0;
    table << i * dt_s << ',' << std::round(rate / kAlpha - 20.0 + noise(random)) << ',' << angle_deg
          << '\n';
    angle_deg += rate * dt_s;
  }
  return table.str();
}

// Counts in a column of rad/s.
TEST(Analyze, AndTraceEndAsFailuresWhereTheUnitCannotBeThatOfTheColumn) {
  const TemporaryFolder folder;
  std::string text = TurnTable();
  text.replace(text.find("# gyro_lsb_per_deg_s = 131\n"), 27, "");
  text.replace(text.find("gyro_z_lsb"), 10, "gyro_z_rad_s");
  const auto table = folder.Write("turns.csv", text);
  for (const char* command : {"analyze", "trace"}) {
    const Finished finished = Gyrobench({command, table});
    EXPECT_EQ(finished.status, 1) << command;
    EXPECT_THAT(finished.err, HasSubstr("the values of gyro_z_rad_s are counts")) << command;
    EXPECT_THAT(finished.err, HasSubstr("Name the column gyro_z_lsb")) << command;
    EXPECT_THAT(finished.err, Not(HasSubstr("wiring"))) << command;
    EXPECT_THAT(Flat(finished.out), HasSubstr("gyro_z_rad_s are counts")) << command;
  }
}

TEST(Analyze, FindsTheScaleOfATableAndSaysTheSameInTextAsInJson) {
  const TemporaryFolder folder;
  const auto table = folder.Write("turns.csv", TurnTable());
  const Finished text = Gyrobench({"analyze", table});
  const Finished machine = Gyrobench({"analyze", "--json", table});
  ASSERT_EQ(text.status, 0) << text.err;
  ASSERT_EQ(machine.status, 0) << machine.err;
  const json result = json::parse(machine.out);
  const json& scale = result.at("scale").at(0);
  const double alpha = scale.at("alpha"), std_error = scale.at("alpha_std_error");
  EXPECT_NEAR(alpha, kAlpha, 5.0 * std_error + 1e-4 * kAlpha);
  EXPECT_THAT(text.out, HasSubstr(presentation::FormatMeasured(alpha, std_error) + "  "));
  EXPECT_THAT(text.out, HasSubstr("deg/s per LSB"));
  EXPECT_THAT(text.out, HasSubstr("Defects"));
}

TEST(Analyze, CountsAndPlacesDefects) {
  const TemporaryFolder folder;
  std::string text = TurnTable();
  const std::size_t line = text.find("\n1,");  // the row at 1 s, once more
  ASSERT_NE(line, std::string::npos);
  const std::string row = text.substr(line, text.find('\n', line + 1) - line);
  text.insert(line, row);
  const auto table = folder.Write("turns.csv", text);
  const json result = json::parse(Gyrobench({"analyze", "--json", table}).out);
  ASSERT_FALSE(result.at("defects").empty());
  EXPECT_EQ(result.at("defects").at(0).at("kind"), "repeated_time");
  EXPECT_EQ(result.at("defects").at(0).at("count"), 1);
  EXPECT_THAT(Gyrobench({"analyze", table}).out, HasSubstr("repeated_time      1  1.000 s"));
}

// One bad file among many must not cost the others.
TEST(Analyze, GoesOnAfterAnInputThatCannotBeRead) {
  const TemporaryFolder folder;
  const auto good = folder.Write("turns.csv", TurnTable());
  const auto bad = folder.Write("bad.csv", "a,b\n1,2\n");
  const Finished finished = Gyrobench({"analyze", "--json", bad, good});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("bad.csv"));
  EXPECT_EQ(json::parse(finished.out).size(), 1u);
}

class Records : public testing::Test {
 protected:
  void SetUp() override {
    folder_.Write("20260101-000000-scale/run.json", json{{"run_id", "20260101-000000-scale"},
                                                         {"procedure", "scale"},
                                                         {"parameters", {{"turns", 40}}},
                                                         {"start_utime", 1'767'225'600'000'000},
                                                         {"stand", {{"name", "laboratory"}}},
                                                         {"outcome", "done"}}
                                                        .dump());
    folder_.Write("20260101-000000-scale/result.json", Result().dump());
    WriteLog(folder_ / "20260101-000000-scale/events.lcmlog");
    folder_.Write("20260102-000000-bias/run.json", "{ damaged");
    folder_.Write("20260102-000000-bias/events.lcmlog", "");
  }

  static json Result() {
    return {
        {"scale",
         {{{"axis", "z"}, {"unit", "LSB"}, {"alpha", 0.0076204}, {"alpha_std_error", 0.0000313}}}},
        {"bias",
         {{{"axis", "z"},
           {"unit", "LSB"},
           {"reference_temperature_degC", 25.0},
           {"min_temperature_degC", -5.0},
           {"max_temperature_degC", 30.0},
           {"coefficients", {-12.25, 0.5, nullptr}},
           {"std_errors", {0.15, 0.01, nullptr}},
           {"remarks", {"short run"}}}}},
        {"defects", json::array()}};
  }

  // Two seconds of one sensor at rest, as the daemon records it.
  static void WriteLog(const std::filesystem::path& file) {
    recording::EventLogWriter log(file);
    gyro_t block{};
    block.run_id = "20260101-000000-scale";
    block.tick_rate_hz = 250000.0;
    block.gyro_lsb_per_deg_s = 131.0;
    block.accel_lsb_per_g = 16384.0;
    block.n = 10;
    block.gyro_lsb.assign(3, std::vector<std::int16_t>(10, 5));
    block.accel_lsb.assign(3, std::vector<std::int16_t>(10, 0));
    block.temperature_degC.assign(10, 25.0F);
    for (std::int64_t b = 0; b < 40; ++b) {
      block.seq = b;
      block.first_counter = 10 * b;
      block.sample_utime.clear();
      block.sample_tick.clear();
      for (std::int64_t i = 0; i < 10; ++i) {
        block.sample_utime.push_back(1'767'225'600'000'000 + 5000 * (10 * b + i));
        block.sample_tick.push_back(1250 * (10 * b + i));
      }
      block.utime = block.sample_utime.back();
      block.unit_tick = block.sample_tick.back();
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(block.getEncodedSize()));
      block.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
      log.Write("GYROBENCH_GYRO", block.utime, bytes.data(), bytes.size());
    }
    log.Close();
  }

  TemporaryFolder folder_;
};

TEST_F(Records, RunsListsEveryRecordAndADamagedOneToo) {
  const Finished finished = Gyrobench({"runs", "--records", folder_ / ""});
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(finished.out, HasSubstr("20260101-000000-scale"));
  EXPECT_THAT(finished.out, HasSubstr("alpha z 0.007620 ± 0.000031 deg/s per LSB"));
  EXPECT_THAT(finished.out, HasSubstr("damaged run.json"));
  const json list = json::parse(Gyrobench({"runs", "--json", "--records", folder_ / ""}).out);
  EXPECT_EQ(list.at("runs").size(), 2u);
}

// On a terminal of 100 columns, for which all that is said of the run is too long.
TEST_F(Records, RunsCutsNoNumber) {
  json result = Result();
  result["scale"].push_back(result["scale"][0]);
  result["scale"][1]["axis"] = "y";
  result["scale"][1]["alpha"] = 0.0076309;
  folder_.Write("20260101-000000-scale/result.json", result.dump());
  ChildProcess program({GYROBENCH_PROGRAM, "runs", "--records", folder_ / ""}, {}, true);
  const Finished finished = program.Wait();
  EXPECT_EQ(finished.status, 0);
  EXPECT_THAT(Flat(finished.out), HasSubstr("0.007620 ± 0.000031"));
  EXPECT_THAT(Flat(finished.out), HasSubstr("0.007631 ± 0.000031 deg/s per LSB"));
}

TEST_F(Records, ShowPrintsTheRunAndItsResults) {
  const Finished finished = Gyrobench({"show", "20260101", "--records", folder_ / ""});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("turns = 40"));
  EXPECT_THAT(finished.out, HasSubstr("laboratory"));
  EXPECT_THAT(finished.out, HasSubstr("-12.25 ± 0.15"));
  EXPECT_THAT(finished.out, HasSubstr("short run"));
  EXPECT_THAT(finished.out, Not(HasSubstr("nan")));
}

TEST_F(Records, ShowDrawsTheBiasWhereItWasWhatTheRunMeasured) {
  json result = Result();
  result.erase("scale");
  result["bias"][0]["coefficients"].erase(2);  // a curve that is not known in full is not drawn
  folder_.Write("20260103-000000-bias/result.json", result.dump());
  folder_.Write("20260103-000000-bias/events.lcmlog", "");
  const Finished finished = Gyrobench({"show", folder_ / "20260103-000000-bias"});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("beta z [LSB]"));
  EXPECT_THAT(finished.out, HasSubstr("no run.json"));
}

// Aborted at once: there is nothing to say of defects and estimates.
TEST_F(Records, ShowOfARunThatMeasuredNothingSaysSoAndItsOutcomeOnce) {
  const json run = {
      {"procedure", "full"}, {"outcome", "aborted"}, {"message", "aborted by the operator"}};
  const json result = {{"samples", 0},
                       {"remarks", {"measurement: no gyro sample; expected a measurement"}}};
  folder_.Write("20260104-000000-full/run.json", run.dump());
  folder_.Write("20260104-000000-full/result.json", result.dump());
  folder_.Write("20260104-000000-full/events.lcmlog", "");
  const Finished finished = Gyrobench({"show", folder_ / "20260104-000000-full"});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("outcome    aborted by the operator\n"));
  EXPECT_EQ(Count(finished.out, "aborted"), 1);
  EXPECT_THAT(finished.out, HasSubstr("no results: the gyro gave no sample"));
  EXPECT_THAT(finished.out, Not(HasSubstr("Defects")));
}

TEST_F(Records, ShowByPathNeedsNoStandFile) {
  EXPECT_EQ(Gyrobench({"show", folder_ / "20260101-000000-scale"}).status, 0);
}

TEST_F(Records, AnUnknownRunIsAnErrorThatNamesIt) {
  const Finished finished = Gyrobench({"show", "2019", "--records", folder_ / ""});
  EXPECT_EQ(finished.status, 1);
  EXPECT_THAT(finished.err, HasSubstr("2019"));
}

TEST_F(Records, ExportWritesATableAndReplacesNoneUnasked) {
  const std::string record = folder_ / "20260101-000000-scale", table = folder_ / "out.csv";
  const Finished first = Gyrobench({"export", record, "-o", table, "--json"});
  ASSERT_EQ(first.status, 0) << first.err;
  EXPECT_EQ(json::parse(first.out).at("rows"), 400);
  const Finished second = Gyrobench({"export", record, "-o", table});
  EXPECT_EQ(second.status, 1);
  EXPECT_THAT(second.err, HasSubstr("--overwrite"));
  EXPECT_EQ(Gyrobench({"export", record, "-o", table, "--overwrite"}).status, 0);
}

}  // namespace
}  // namespace gyrobench::cli
