// `gyrobench apply`: a table comes out with corrected rates and all else as it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "calibration/artefact/calibration_file.h"
#include "tests/cli/child_process.h"
#include "tests/cli/gyro_z.h"
#include "tests/cli/program.h"
#include "tests/temporary_folder.h"
#include "tests/words.h"

namespace gyrobench::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> LinesOf(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<std::string> Fields(const std::string& line) {
  std::vector<std::string> fields;
  std::stringstream in(line + ",");
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

class Apply : public testing::Test {
 protected:
  Apply() : calibration_(folder_.Write("cal.json", ToJson(GyroZ()).dump())) {}

  // 20 s at 25 degC, with a reference that must not matter and columns that must survive.
  std::string Table(const std::string& comments = "# gyro_lsb_per_deg_s = 131\n") const {
    std::ostringstream table;
    table << comments << "t_s,note_v,gyro_z_lsb,\"temp_degC\",ref_angle_z_deg,supply_v\n";
    for (int i = 0; i < 2000; ++i) {
      table << i * 0.01 << ",1.50," << 1000 + i % 7 << ",25.0," << i * 7 << ","
            << (i % 3 == 0 ? "3.300" : "") << "\n";
    }
    return table.str();
  }
  Finished Run(const std::filesystem::path& table, const std::string& output = "out.csv",
               std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"apply", calibration_, table, "-o", folder_ / output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Gyrobench(arguments);
  }
  // The message of a refusal: exit status 1, and nothing left behind.
  std::string Refusal(const std::filesystem::path& table,
                      std::vector<std::string> more = {}) const {
    const Finished finished = Run(table, "refused.csv", std::move(more));
    EXPECT_EQ(finished.status, 1) << finished.out;
    EXPECT_FALSE(std::filesystem::exists(folder_ / "refused.csv"));
    for (const auto& entry : std::filesystem::directory_iterator(folder_ / ""))
      EXPECT_NE(entry.path().extension(), ".part") << entry.path();
    return finished.err;
  }

  TemporaryFolder folder_;
  std::filesystem::path calibration_;
};

TEST_F(Apply, ReplacesTheGyroInItsPlaceAndLeavesEveryOtherFieldAsItIs) {
  const auto table = folder_.Write("in.csv", Table());
  const Finished finished = Run(table);
  ASSERT_EQ(finished.status, 0) << finished.err;
  const auto before = LinesOf(table), after = LinesOf(folder_ / "out.csv");
  ASSERT_EQ(after.size(), before.size());
  EXPECT_THAT(after[0], HasSubstr("# corrected_by = gyrobench"));
  EXPECT_THAT(after[0], HasSubstr("cal.json"));
  EXPECT_EQ(after[1], "t_s,note_v,gyro_z_deg_s,temp_degC,ref_angle_z_deg,supply_v");
  for (std::size_t i = 2; i < after.size(); ++i) {
    std::vector<std::string> in = Fields(before[i]), out = Fields(after[i]);
    const double expected = (std::stod(in[2]) / 131.0 - 0.5 - 0.01 * (25.0 - 30.0)) / 1.02;
    ASSERT_NEAR(std::stod(out[2]), expected, 2e-7);
    in[2] = out[2];
    ASSERT_EQ(in, out);
  }
}

// A ramp in the temperature, constant outside of its two knots, and a product with a column.
TEST_F(Apply, TakesOffCurvesAndProductsThatNoCatalogueHas) {
  calibration::Calibration calibration = GyroZ();
  calibration::ModelTerm ramp;
  ramp.id = "empirical(T)";
  ramp.origin = calibration::EffectOrigin::kEmpirical;
  ramp.factors = {"T"};
  ramp.knots = {24.0, 28.0};
  ramp.coefficients = {0.0, 0.2};
  calibration::ModelTerm product;
  product.id = "composed(w*T)";
  product.origin = calibration::EffectOrigin::kComposed;
  product.factors = {"w", "T"};
  product.offsets = {0.0, 30.0};
  product.coefficients = {-1e-3};
  calibration.channels.front().model.terms = {ramp, product};
  calibration_ = folder_.Write("terms.json", ToJson(calibration).dump());
  for (const double T_degC : {20.0, 25.0, 27.5, 35.0}) {
    std::string text = Table();
    const std::string field = "," + std::to_string(T_degC) + ",";
    for (std::size_t at = 0; (at = text.find(",25.0,", at)) != std::string::npos; at += 2)
      text.replace(at, 6, field);
    const auto table = folder_.Write("in.csv", text);
    const Finished finished = Run(table, "out.csv", {"--overwrite"});
    ASSERT_EQ(finished.status, 0) << finished.err;
    const auto before = LinesOf(table), after = LinesOf(folder_ / "out.csv");
    const double share = std::clamp((T_degC - 24.0) / (28.0 - 24.0), 0.0, 1.0);
    for (std::size_t i = 2; i < after.size(); i += 100) {
      const double xi = std::stod(Fields(before[i])[2]) / 131.0;
      const double bias = 0.5 + 0.01 * (T_degC - 30.0) + 0.2 * share;
      const double expected = (xi - bias) / (1.02 - 1e-3 * (T_degC - 30.0));
      ASSERT_NEAR(std::stod(Fields(after[i])[2]), expected, 2e-7) << T_degC;
    }
  }
}

TEST_F(Apply, SaysOnceThatEffectsOfOneIdAreNotApplied) {
  calibration::Calibration calibration = GyroZ();
  calibration::ModelTerm ripple;
  ripple.id = "angle.ripple";
  ripple.owner = calibration::EffectOwner::kBench;
  ripple.coefficients = {0.1, 0.2};
  for (const double k : {100.0, 200.0, 300.0}) {
    ripple.nonlinear = {k};
    calibration.channels.front().model.terms.push_back(ripple);
  }
  calibration_ = folder_.Write("ripples.json", ToJson(calibration).dump());
  const Finished finished = Run(folder_.Write("in.csv", Table()));
  ASSERT_EQ(finished.status, 0) << finished.err;
  const std::size_t first = finished.out.find("angle.ripple");
  EXPECT_NE(first, std::string::npos);
  EXPECT_EQ(finished.out.find("angle.ripple", first + 1), std::string::npos);
  EXPECT_THAT(finished.out, HasSubstr("(3 times)"));
}

TEST_F(Apply, UsesNoReference) {
  std::string changed = Table();
  for (std::size_t at = 0; (at = changed.find(",25.0,", at)) != std::string::npos; at += 6)
    changed.insert(at + 6, "9");
  ASSERT_EQ(Run(folder_.Write("a.csv", Table()), "a-out.csv").status, 0);
  ASSERT_EQ(Run(folder_.Write("b.csv", changed), "b-out.csv").status, 0);
  const auto a = LinesOf(folder_ / "a-out.csv"), b = LinesOf(folder_ / "b-out.csv");
  for (std::size_t i = 2; i < a.size(); ++i) ASSERT_EQ(Fields(a[i])[2], Fields(b[i])[2]);
}

TEST_F(Apply, KeepsCommentsButTheSensitivityThatNoLongerHolds) {
  const auto table = folder_.Write(
      "in.csv", Table("# a word\n# gyro_lsb_per_deg_s = 131\n# sensor = MPU-17\n# place = roof\n"));
  ASSERT_EQ(Run(table).status, 0);
  const auto lines = LinesOf(folder_ / "out.csv");
  EXPECT_THAT(std::vector(lines.begin(), lines.begin() + 3),
              ElementsAre("# a word", "# sensor = MPU-17", "# place = roof"));
}

TEST_F(Apply, KeepsTheNumberOfRowsAndLetsNoRawValuePassForACorrectedOne) {
  std::string text = Table();
  text.replace(text.find("\n5,"), 3, "\n5,extra,");         // a field too many
  text.replace(text.find("\n6,1.50,1"), 9, "\n6,1.50,x1");  // no number
  text.replace(text.find("\n7,"), 3, "\n,");                // no time
  const auto table = folder_.Write("in.csv", text);
  const Finished finished = Run(table, "out.csv", {"--json"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const json summary = json::parse(finished.out);
  EXPECT_EQ(summary.at("rows"), 2000);
  EXPECT_EQ(summary.at("rows_without_time"), 2);
  EXPECT_EQ(summary.at("channels").at(0).at("missing"), 1);
  EXPECT_EQ(summary.at("channels").at(0).at("corrected"), 1997);
  const auto lines = LinesOf(folder_ / "out.csv");
  EXPECT_EQ(lines.size(), 2002u);
  EXPECT_EQ(lines[2 + 500], ",,,,,");
  EXPECT_EQ(Fields(lines[2 + 600])[2], "");
}

// A reference that is logged by itself takes nothing away from the gyro.
TEST_F(Apply, CountsNoSampleAsMissingInARowOfTheReferenceAlone) {
  std::string text = "# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb,temp_degC,ref_angle_z_deg\n";
  for (int i = 0; i < 2000; ++i) {
    const std::string t_s = std::to_string(0.01 * i), half_s = std::to_string(0.01 * i + 0.005);
    text += t_s + (i == 700 ? ",,25,\n" : ",1000,25,\n") + half_s + ",,,7.5\n";
  }
  const auto table = folder_.Write("in.csv", text);
  const Finished finished = Run(table, "out.csv", {"--json"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const json summary = json::parse(finished.out);
  EXPECT_EQ(summary.at("rows"), 4000);
  EXPECT_EQ(summary.at("channels").at(0).at("missing"), 1);
  EXPECT_EQ(summary.at("channels").at(0).at("corrected"), 1999);
  const auto before = LinesOf(table), after = LinesOf(folder_ / "out.csv");
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 3; i < after.size(); i += 2) ASSERT_EQ(after[i], before[i]);
}

TEST_F(Apply, NamesTheUnitThatTheColumnsOfARefusedTableAreIn) {
  const std::string says =
      Refusal(folder_.Write("in.csv", "t_s,gyro_z_rad_s,temp_degC\n0,0.1,25\n0.01,0.1,25\n"));
  EXPECT_THAT(says, AllOf(HasSubstr("gyro z is in rad/s"), HasSubstr("expects LSB")));
}

TEST_F(Apply, WarnsLoudlyOfWhatLiesBeyondTheCalibrationAndByHowMuch) {
  std::string text = Table();
  for (std::size_t at = 0; (at = text.find(",25.0,", at)) != std::string::npos;)
    text.replace(at, 6, ",55.0,");
  const auto table = folder_.Write("in.csv", text);
  const std::string says = Flat(Run(table).out);
  EXPECT_THAT(says, HasSubstr("WARNING: 2 000 of 2 000 samples (100.0 %) lie outside"));
  EXPECT_THAT(says, HasSubstr("gyro z: 2 000 samples outside of its 20.0 to 40.0 degC, at 55.0"));
  // A warning is no error, but neither a machine nor silence may swallow it.
  for (const char* option : {"-q", "--json"}) {
    const Finished finished = Run(table, "out.csv", {"--overwrite", option});
    EXPECT_EQ(finished.status, 0);
    EXPECT_THAT(finished.err, HasSubstr("WARNING")) << option;
  }
  EXPECT_EQ(Run(folder_.Write("within.csv", Table()), "b.csv", {"-q"}).err, "");
}

// A reference that is logged beside the gyro has rows of its own.
TEST_F(Apply, CountsSamplesAndNotTheRowsOfTheReference) {
  std::ostringstream table;
  table << "# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb,temp_degC,ref_angle_z_deg\n";
  for (int i = 0; i < 1000; ++i) {
    table << 0.01 * i << "," << 1000 + i % 7 << ",55.0,\n";
    table << 0.01 * i + 0.004 << ",,," << i << "\n";
  }
  const auto file = folder_.Write("in.csv", table.str());
  EXPECT_THAT(Flat(Run(file).out), HasSubstr("1 000 of 1 000 samples (100.0 %) lie outside"));
  const json summary = json::parse(Run(file, "b.csv", {"--json"}).out);
  EXPECT_EQ(summary.at("samples"), 1000);
  EXPECT_EQ(summary.at("rows_outside"), 1000);
}

// At twice the rates and 15 degC beyond the temperatures of a calibration with a cubic term and a
// bias of the second order, both of which turn back there.
TEST_F(Apply, WritesEveryRowBeyondTheCalibrationWithItsValuesAtTheEdge) {
  calibration::Calibration calibration = GyroZ();
  calibration::ChannelModel& model = calibration.channels.front().model;
  calibration::ModelTerm cubic;
  cubic.id = "scale.cubic";
  cubic.coefficients = {-1e-4};
  model.terms = {cubic};
  model.bias_deg_s = {0.5, 0.2, -0.02};
  calibration_ = folder_.Write("terms.json", ToJson(calibration).dump());
  std::ostringstream table;
  table << "# gyro_lsb_per_deg_s = 131\nt_s,gyro_z_lsb,temp_degC\n";
  table.precision(12);
  for (int i = 0; i < 2000; ++i) {
    const double w = 80.0 * std::sin(0.01 * i), held = std::clamp(w, -40.0, 40.0);
    const double bias = 0.5 + 0.2 * 10.0 - 0.02 * 100.0;  // at 40 degC
    table << 0.01 * i << ',' << 131.0 * (1.02 * w + bias - 1e-4 * held * held * held) << ",55\n";
  }
  const Finished finished = Run(folder_.Write("in.csv", table.str()), "out.csv", {"--json"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(json::parse(finished.out).at("channels").at(0).at("corrected"), 2000);
  const auto lines = LinesOf(folder_ / "out.csv");
  for (std::size_t i = 0; i < 2000; ++i)
    ASSERT_NEAR(std::stod(Fields(lines[i + 2])[1]), 80.0 * std::sin(0.01 * static_cast<double>(i)),
                1e-6);
}

TEST_F(Apply, SaysThatNothingShowsThatTableAndCalibrationBelongTogether) {
  const auto nameless = folder_.Write("nameless.csv", Table());
  EXPECT_THAT(Flat(Run(nameless).out), HasSubstr("calibration is of sensor MPU-17"));
  EXPECT_THAT(Run(nameless, "a.csv", {"--any-sensor"}).out, Not(HasSubstr("MPU-17")));
  const std::string comment = "# gyro_lsb_per_deg_s = 131\n# sensor = MPU-17\n";
  const auto named = folder_.Write("named.csv", Table(comment));
  EXPECT_THAT(Run(named, "b.csv").out, Not(HasSubstr("MPU-17")));
  calibration::Calibration calibration = GyroZ();
  calibration.sensor.clear();
  calibration_ = folder_.Write("nameless.json", ToJson(calibration).dump());
  EXPECT_THAT(Flat(Run(named, "c.csv").out), HasSubstr("is of sensor MPU-17"));
  EXPECT_THAT(Run(nameless, "d.csv").out, Not(HasSubstr("belong together")));
}

TEST_F(Apply, ShowsTheOrderOfItsArgumentsWhereATableStandsForTheCalibration) {
  const auto table = folder_.Write("in.csv", Table());
  const std::string output = folder_ / "out.csv";
  const Finished swapped = Gyrobench({"apply", table, calibration_, "-o", output});
  EXPECT_EQ(swapped.status, 2);
  EXPECT_THAT(swapped.err, HasSubstr("are swapped"));
  EXPECT_THAT(swapped.err, HasSubstr("gyrobench apply CALIBRATION.json TABLE.csv"));
  const Finished two_tables = Gyrobench({"apply", table, table, "-o", output});
  EXPECT_EQ(two_tables.status, 2);
  EXPECT_THAT(two_tables.err, Not(HasSubstr("swapped")));
  EXPECT_THAT(two_tables.err, HasSubstr("gyrobench apply CALIBRATION.json TABLE.csv"));
}

TEST_F(Apply, SaysWhatItTakesWhereSomethingIsMissing) {
  const Finished alone = Gyrobench({"apply", folder_ / "nofile"});
  EXPECT_EQ(alone.status, 2);
  EXPECT_THAT(alone.err, HasSubstr("gyrobench apply mpu-17.json flight.csv.gz -o"));
  const auto table = folder_.Write("in.csv", Table());
  const Finished absent = Gyrobench({"apply", folder_ / "nofile", table, "-o", folder_ / "o.csv"});
  EXPECT_EQ(absent.status, 1);
  EXPECT_THAT(absent.err, AllOf(HasSubstr("nofile: no such file; expected a calibration"),
                                HasSubstr("gyrobench apply CALIBRATION.json TABLE.csv")));
}

TEST_F(Apply, WritesGzipThatTheProgramReadsAgain) {
  ASSERT_EQ(Run(folder_.Write("in.csv", Table()), "out.csv.gz").status, 0);
  const Finished finished = Gyrobench({"analyze", folder_ / "out.csv.gz", "--json"});
  // The reference of the table turns, and the gyro does not: that cannot be, and is read all the
  // same.
  EXPECT_EQ(finished.status, 1) << finished.err;
  EXPECT_EQ(json::parse(finished.out).at("info").at("gyro_unit"), "deg_s");
}

TEST_F(Apply, RefusesToCorrectATableTwice) {
  ASSERT_EQ(Run(folder_.Write("in.csv", Table())).status, 0);
  EXPECT_THAT(Refusal(folder_ / "out.csv"), HasSubstr("corrected already"));
}

TEST_F(Apply, RefusesWhatTheCalibrationIsNotOf) {
  EXPECT_THAT(Refusal(folder_.Write("other.csv", Table("# sensor = MPU-18\n"))),
              HasSubstr("--any-sensor"));
  EXPECT_EQ(Run(folder_ / "other.csv", "any.csv", {"--any-sensor"}).status, 0);
  EXPECT_THAT(Refusal(folder_.Write("range.csv", Table("# gyro_lsb_per_deg_s = 65.5\n"))),
              HasSubstr("another range"));
  EXPECT_THAT(Refusal(folder_.Write("unit.csv", "t_s,gyro_z_rad_s\n0,1\n1,2\n")),
              HasSubstr("expects LSB"));
  EXPECT_THAT(Refusal(folder_.Write("axis.csv", "t_s,gyro_x_lsb\n0,1\n1,2\n")),
              HasSubstr("none of its axes"));
}

TEST_F(Apply, RefusesTablesThatAreNoneByFileAndLine) {
  EXPECT_THAT(Refusal(folder_.Write("no-gyro.csv", "t_s,temp_degC\n0,1\n")),
              HasSubstr("no column of the gyro"));
  EXPECT_THAT(Refusal(folder_.Write("text.csv", "hello\n")), HasSubstr("text.csv:1"));
  EXPECT_THAT(Refusal(folder_.Write("empty.csv", "")), HasSubstr("empty.csv: no measurement"));
  EXPECT_THAT(Refusal(folder_ / "empty.csv"), HasSubstr("found an empty file"));
  EXPECT_THAT(Refusal(folder_.Write("rows.csv", "t_s,gyro_z_lsb\n")), HasSubstr("found none"));
  EXPECT_THAT(Refusal(folder_.Write("unit.csv", "t_s,gyro_z_dps\n0,1\n")),
              HasSubstr("found gyro_z_dps"));
  EXPECT_THAT(Refusal(folder_.Write("back.csv", "t_s,gyro_z_lsb\n1,1\n0.5,2\n")),
              HasSubstr("back.csv:3: time goes backwards"));
  EXPECT_THAT(Refusal(folder_ / "absent.csv"), HasSubstr("absent.csv"));
}

TEST_F(Apply, RefusesCalibrationsThatAreNone) {
  const auto table = folder_.Write("in.csv", Table());
  calibration_ = folder_ / "absent.json";
  EXPECT_THAT(Refusal(table), HasSubstr("absent.json"));
  calibration_ = folder_.Write("empty.json", "");
  EXPECT_THAT(Refusal(table), HasSubstr("found an empty file"));
  calibration_ = folder_.Write("broken.json", "{\"format\":");
  EXPECT_THAT(Refusal(table), HasSubstr("no valid JSON"));
  calibration_ = folder_.Write("trace.json", R"({"format": "gyrobench.trace/1"})");
  EXPECT_THAT(Refusal(table), HasSubstr("no calibration"));
  calibration_ = folder_.Write("next.json", R"({"format": "gyrobench.calibration/9"})");
  EXPECT_THAT(Refusal(table), HasSubstr("another version"));
}

TEST_F(Apply, ReplacesNoFileUnaskedAndWritesTablesOnly) {
  const auto table = folder_.Write("in.csv", Table());
  folder_.Write("out.csv", "mine");
  EXPECT_THAT(Run(table).err, HasSubstr("--overwrite"));
  EXPECT_EQ(LinesOf(folder_ / "out.csv"), std::vector<std::string>{"mine"});
  EXPECT_EQ(Run(table, "out.csv", {"--overwrite"}).status, 0);
  EXPECT_THAT(Run(table, "out.json").err, HasSubstr(".csv.gz"));
  EXPECT_EQ(Gyrobench({"apply", calibration_}).status, 2);
}

TEST_F(Apply, IsQuietWhereAskedTo) {
  EXPECT_EQ(Run(folder_.Write("in.csv", Table()), "out.csv", {"-q"}).out, "");
}

}  // namespace
}  // namespace gyrobench::cli
