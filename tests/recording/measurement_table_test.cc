#include "recording/measurement_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <sstream>

#include "base/error.h"
#include "gzip.h"
#include "recording/replay.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class Table : public testing::Test {
 protected:
  KeepingSink Read(const std::string& bytes) {
    WriteFile(folder_ / "table.csv", bytes);
    KeepingSink sink;
    ReplayTable(folder_ / "table.csv", sink);
    return sink;
  }
  std::string ErrorOf(const std::string& bytes) {
    return MessageOf<DataError>([&] { Read(bytes); });
  }
  static std::vector<double> Times(const KeepingSink& sink) {
    std::vector<double> times;
    for (const GyroSample& sample : sink.gyro) times.push_back(sample.t_s);
    return times;
  }

  TemporaryFolder folder_;
};

// Each took as long as a comparison with all names that might be meant: 100,000 took 20 s.
TEST_F(Table, CommentsThatAreNoneOfItsOwnAreBounded) {
  const auto table = [](int notes) {
    std::string bytes;
    for (int i = 0; i < notes; ++i) bytes += "# station" + std::to_string(i) + " = x\n";
    return bytes + "t_s,gyro_z_lsb\n0,1\n";
  };
  EXPECT_EQ(Read(table(1000)).gyro.size(), 1u);
  EXPECT_THAT(ErrorOf(table(100'000)), HasSubstr(":1001: more than 1000 comments"));
}

// Every column has a value of its own, so that a swap shows.
TEST_F(Table, EveryColumnArrivesInItsPlaceAndUnit) {
  const KeepingSink sink = Read(
      "temp_degC,gyro_z_lsb,ref_inner_deg,t_s,gyro_x_lsb,accel_y_m_s2,ref_outer_deg,gyro_y_lsb,ref_"
      "middle_deg,"
      "accel_x_m_s2,accel_z_m_s2,unit_tick_s\n"
      "21.5,3,30,0.25,1,19.6133,10,2,20,9.80665,-9.80665,0.125\n");
  ASSERT_EQ(sink.gyro.size(), 1u);
  EXPECT_EQ(sink.gyro[0].t_s, 0.25);
  EXPECT_THAT(sink.gyro[0].xi, ElementsAre(1, 2, 3));
  EXPECT_THAT(sink.gyro[0].accel_g, ElementsAre(1, 2, -1));
  EXPECT_EQ(sink.gyro[0].temperature_degC, 21.5);
  ASSERT_EQ(sink.angles.size(), 3u);
  for (const AngleSample& angle : sink.angles) EXPECT_EQ(angle.angle_deg, 10.0 * (angle.axis + 1));
  ASSERT_EQ(sink.ticks.size(), 1u);
  EXPECT_EQ(sink.ticks[0].tick_s, 0.125);
  EXPECT_EQ(sink.ticks[0].host_s, 0.25);
  EXPECT_EQ(sink.info.reference, ReferenceKind::kStandAngles);
  EXPECT_TRUE(sink.info.temperature_present);
}

TEST_F(Table, CommentsSayWhatIsTrueOfTheWholeTable) {
  const KeepingSink sink = Read(
      "# a remark\n#site_latitude_deg=55.75\n# site_heading_deg = -30\n# gyro_lsb_per_deg_s = 131\n"
      "# gear_ratio = 40\n# sensor = GB 17\n# power_on = A\n# operator = x = y\n# "
      "stop_accuracy_deg = 0.025\n"
      "# mount_x_deg = 1\n# mount_y_deg = 2\n# mount_z_deg = 3\n# outer_middle_deg = 4\n"
      "# middle_inner_deg = 5\n# gyro_delay_s = 0.0048\n# ref_delay_s = 5e-4\n"
      "t_s,gyro_z_lsb\n0,1\n");
  EXPECT_EQ(sink.info.site_latitude_deg, 55.75);
  EXPECT_EQ(sink.info.site_heading_deg, -30);
  EXPECT_EQ(sink.info.gyro_units_per_deg_s, 131);
  EXPECT_EQ(sink.info.gear_ratio, 40);
  EXPECT_EQ(sink.info.stop_accuracy_deg, 0.025);
  EXPECT_EQ(sink.info.geometry, (StandGeometry{{1, 2, 3}, 4, 5}));
  EXPECT_EQ(sink.info.gyro_delay_s, 0.0048);
  EXPECT_EQ(sink.info.reference_delay_s, 0.0005);
  EXPECT_EQ(sink.info.sensor, "GB 17");
  EXPECT_EQ(sink.info.power_on, "A");
  EXPECT_EQ(sink.info.notes.at("operator"), "x = y");
}

TEST_F(Table, TheUnitOfTheGyroGivesTheNominalSensitivity) {
  EXPECT_EQ(Read("t_s,gyro_y_deg_s\n0,1\n").info.gyro_units_per_deg_s, 1.0);
  EXPECT_DOUBLE_EQ(*Read("t_s,gyro_y_rad_s\n0,1\n").info.gyro_units_per_deg_s,
                   std::numbers::pi / 180.0);
  EXPECT_FALSE(Read("t_s,gyro_y_lsb\n0,1\n").info.gyro_units_per_deg_s.has_value());
}

TEST_F(Table, UnknownColumnsAreCovariatesAndUnscaledAccelerationIsOne) {
  const std::string table = "t_s,gyro_z_lsb,supply_v,accel_x_lsb,gyro_z_volt\n0,1,2,8192,4\n";
  EXPECT_THAT(Read(table).info.covariates, ElementsAre("supply_v", "accel_x_lsb", "gyro_z_volt"));
  const KeepingSink scaled = Read("# accel_lsb_per_g = 16384\n" + table);
  EXPECT_THAT(scaled.info.covariates, ElementsAre("supply_v", "gyro_z_volt"));
  EXPECT_EQ(scaled.gyro[0].accel_g[0], 0.5);
}

// Names and places mixed, so that a swap shows; a value of a slow column without a gyro sample.
TEST_F(Table, CovariatesComeInTheirOrderBeforeTheSampleOfTheirTime) {
  struct OrderSink : KeepingSink {
    void OnCovariates(double t_s, std::span<const double> values) override {
      KeepingSink::OnCovariates(t_s, values);
      gyro_before.push_back(gyro.size());
    }
    std::vector<std::size_t> gyro_before;
  } sink;
  WriteFile(folder_ / "table.csv",
            "fan,t_s,supply_v,gyro_z_lsb,current_a\n"
            "1,0,2,10,3\n,1,,11,\n,2,5,,\n,3,,,\n9,4,nan,12,7\n");
  ReplayTable(folder_ / "table.csv", sink);
  EXPECT_THAT(sink.info.covariates, ElementsAre("fan", "supply_v", "current_a"));
  EXPECT_THAT(sink.covariate_times_s, ElementsAre(0, 1, 2, 4));
  EXPECT_THAT(sink.gyro_before, ElementsAre(0, 1, 2, 2));
  EXPECT_THAT(sink.covariates[0], ElementsAre(1, 2, 3));
  EXPECT_THAT(sink.covariates[1], testing::Each(testing::IsNan()));
  EXPECT_THAT(sink.covariates[2], ElementsAre(testing::IsNan(), 5, testing::IsNan()));
  EXPECT_THAT(sink.covariates[3], ElementsAre(9, testing::IsNan(), 7));
}

TEST_F(Table, TheHeadsErrorsNameLineAndWhatWasExpected) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("an empty file"));
  EXPECT_THAT(ErrorOf("# only\n"), HasSubstr("comments only"));
  EXPECT_THAT(ErrorOf("# a = b\ntime,gyro_x_lsb\n0,1\n"), HasSubstr(":2: no measurement table"));
  EXPECT_THAT(ErrorOf("time,gyro_x_lsb\n0,1\n"), HasSubstr("is 'time' meant? Rename it to t_s"));
  EXPECT_THAT(ErrorOf("t_s;gyro_x_lsb\n0;1\n"), HasSubstr("separated by ';': put commas there"));
  EXPECT_THAT(ErrorOf("t_s\tgyro_x_lsb\n0\t1\n"), HasSubstr("separated by tabs"));
  EXPECT_THAT(ErrorOf("a,b\n0,1\n"),
              testing::Not(testing::AnyOf(HasSubstr("meant"), HasSubstr("separated"))));
  EXPECT_THAT(ErrorOf("t_s,temp_degC\n"), HasSubstr("expected at least one of gyro_x_lsb"));
  EXPECT_THAT(ErrorOf("t_s,gyro_x_lsb,gyro_y_deg_s\n"),
              HasSubstr("gyro_x_lsb, gyro_y_deg_s mix units"));
  EXPECT_THAT(ErrorOf("t_s,gyro_x_lsb,gyro_x_lsb\n"), HasSubstr("gyro_x_lsb is there twice"));
  EXPECT_THAT(ErrorOf("t_s,gyro_x_lsb,ref_qw\n"),
              HasSubstr("needs ref_qw, ref_qx, ref_qy, ref_qz"));
  EXPECT_THAT(ErrorOf("t_s,gyro_x_lsb,ref_inner_deg,ref_angle_x_deg\n"),
              HasSubstr("two kinds of reference"));
  EXPECT_THAT(ErrorOf("t_s,gyro_x_lsb,\n"), HasSubstr("no name"));
  EXPECT_THAT(ErrorOf("#site_latitude_deg = 91\nt_s,gyro_x_lsb\n"),
              HasSubstr("expected a number -90 .. 90"));
  EXPECT_THAT(ErrorOf("#gear_ratio = x\nt_s,gyro_x_lsb\n"), HasSubstr(":1: gear_ratio = x"));
  EXPECT_THAT(ErrorOf("#gyro_delay_s = 4.8\nt_s,gyro_x_lsb\n"),
              HasSubstr(":1: gyro_delay_s = 4.8: expected a number 0 .. 1"));
  EXPECT_THAT(ErrorOf("# a\n#mount_x_deg = nan\nt_s,gyro_x_lsb\n"),
              HasSubstr("table.csv:2: mount_x_deg = nan: expected a number -180 .. 180"));
  EXPECT_THAT(ErrorOf("#mount_y_deg = side\nt_s,gyro_x_lsb\n"),
              HasSubstr(":1: mount_y_deg = side"));
  EXPECT_THAT(ErrorOf("#outer_middle_deg = -10.5\nt_s,gyro_x_lsb\n"),
              HasSubstr("expected a number -10 .. 10"));
  EXPECT_THAT(ErrorOf("#sensor = x\n#sensor = y\nt_s,gyro_x_lsb\n"), HasSubstr("given twice"));
  EXPECT_THAT(ErrorOf(std::string("\x7f"
                                  "ELF\0\0\0\1\2\n",
                                  10)),
              HasSubstr("binary data"));
  EXPECT_THAT(ErrorOf(std::string(300'000, 'x')), HasSubstr("a line of over"));
  EXPECT_THAT(MessageOf<DataError>([&] { TableReader reader(folder_ / "none.csv"); }),
              HasSubstr("none.csv: cannot be opened: No such file"));
  EXPECT_THAT(MessageOf<DataError>([&] { TableReader reader(folder_.path()); }),
              HasSubstr("is a folder"));
}

TEST_F(Table, AHeaderAloneIsATableWithoutRows) {
  const KeepingSink sink = Read("t_s,gyro_x_lsb");
  EXPECT_TRUE(sink.gyro.empty());
  EXPECT_TRUE(sink.defects.empty());
  EXPECT_EQ(sink.infos, 1);
}

TEST_F(Table, LineEndsMarksAndQuotesOfSpreadsheetsAreRead) {
  const KeepingSink sink =
      Read("\xEF\xBB\xBF\"t_s\",\"gyro_x_lsb\"\r\n0, 1\r\n\"1\",+2\r\n\r\n2,3e0");
  EXPECT_THAT(Times(sink), ElementsAre(0, 1, 2));
  EXPECT_EQ(sink.gyro[1].xi[0], 2);
  EXPECT_EQ(sink.gyro[2].xi[0], 3);
  EXPECT_TRUE(sink.defects.empty());
}

// The text's own rounding is the only one: independent of the library that reads.
TEST_F(Table, NumbersAreReadToTheLastBit) {
  std::mt19937_64 random(11);
  std::ostringstream text;
  std::vector<double> expected;
  text << "t_s,gyro_x_deg_s\n";
  for (int i = 0; i < 20'000; ++i) {
    char digits[64];
    const double value = std::ldexp(static_cast<double>(static_cast<std::int64_t>(random())),
                                    static_cast<int>(random() % 60) - 80);
    std::snprintf(digits, sizeof digits,
                  i % 3 == 0   ? "%.9f"
                  : i % 3 == 1 ? "%.17g"
                               : "%.4f",
                  value);
    text << i << ',' << digits << '\n';
    expected.push_back(std::strtod(digits, nullptr));
  }
  const KeepingSink sink = Read(text.str());
  ASSERT_EQ(sink.gyro.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(sink.gyro[i].xi[0], expected[i]) << i;
}

TEST_F(Table, AReferenceSlowerThanTheGyroLeavesFieldsEmpty) {
  const KeepingSink sink =
      Read("t_s,gyro_z_lsb,ref_angle_z_deg\n0,1,5\n0.01,2,\n0.015,,6\n0.02,3,\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.01, 0.02));
  ASSERT_EQ(sink.angles.size(), 2u);
  EXPECT_EQ(sink.angles[1].t_s, 0.015);
  EXPECT_EQ(sink.angles[1].axis, 2);
  EXPECT_TRUE(sink.defects.empty());
}

// Two loggers, one clock: their stamps meet now and then.
TEST_F(Table, LinesOfOneTimeThatFillDifferentColumnsAreOneLine) {
  const KeepingSink sink = Read(
      "t_s,gyro_z_lsb,ref_angle_z_deg\n0,1,\n0,,5\n0.01,2,\n0.015,,6\n0.02,,7\n0.02,3,\n0.03,4,\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.01, 0.02, 0.03));
  ASSERT_EQ(sink.angles.size(), 3u);
  EXPECT_EQ(sink.angles[0].t_s, 0.0);
  EXPECT_EQ(sink.angles[2].t_s, 0.02);
  EXPECT_TRUE(sink.defects.empty());
}

TEST_F(Table, WhatTwoLinesOfOneTimeSayAlikeDoesNotPartThem) {
  const KeepingSink sink =
      Read("t_s,gyro_z_lsb,ref_angle_z_deg,temp_degC\n0,1,,20\n0,,5,20\n0.01,2,,20\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.01));
  ASSERT_EQ(sink.angles.size(), 1u);
  EXPECT_EQ(sink.angles[0].t_s, 0.0);
  EXPECT_TRUE(sink.defects.empty());
}

TEST_F(Table, ADoubledLineOfOneOfTwoLoggersIsLeftOutAndCounted) {
  const KeepingSink sink =
      Read("t_s,gyro_z_lsb,ref_angle_z_deg\n0,1,\n0.01,2,\n0.01,,5\n0.01,,5\n0.02,3,\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.01, 0.02));
  EXPECT_EQ(sink.angles.size(), 1u);
  EXPECT_EQ(sink.Count("repeated_time"), 1);
}

TEST_F(Table, ADoubledRowIsLeftOutAndCounted) {
  const KeepingSink sink = Read("t_s,gyro_z_lsb\n0,1\n0.01,2\n0.01,2\n0.03,3\n0.03,3\n0.03,3\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.01, 0.03));
  EXPECT_EQ(sink.Count("repeated_time"), 3);
  EXPECT_EQ(sink.Where("repeated_time"), "line 4");
}

// A clock that is coarser than the sampling.
TEST_F(Table, DifferentRowsOfOneTimeShareTheTimeUpToTheNext) {
  const KeepingSink sink = Read("t_s,gyro_z_lsb\n0,1\n0,2\n1,3\n1,4\n2,5\n2,6\n");
  EXPECT_EQ(sink.Count("repeated_time"), 3);
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.5, 1, 1.5, 2, 3))
      << "the last has no next: one step on";
}

// A logger that prints milliseconds, and gets rows of 5 ms every 16 ms.
TEST_F(Table, RowsThatCameTogetherStayTogether) {
  constexpr double kPacket_s = 0.016;
  std::string text = "t_s,gyro_z_lsb\n";
  std::vector<double> stamps;
  for (int i = 0; i < 400; ++i) {
    stamps.push_back(kPacket_s * std::floor(0.005 * i / kPacket_s + 1.0));
    // Some the same to the digit.
    text += std::to_string(stamps.back()).substr(0, 5) + "," + std::to_string(i < 150 ? i : i / 2) +
            "\n";
  }
  const std::vector<double> times = Times(Read(text));
  ASSERT_EQ(times.size(), stamps.size());
  for (std::size_t i = 100; i + 10 < times.size(); ++i) {
    EXPECT_GT(times[i], times[i - 1]);
    EXPECT_NEAR(times[i], stamps[i], 1e-5) << "row " << i;
  }
}

TEST_F(Table, APauseAfterARepeatedTimeDoesNotDrawTheSampleIntoIt) {
  const KeepingSink sink = Read("t_s,gyro_z_lsb\n0,1\n0.01,2\n0.01,3\n50,4\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 0.01, testing::DoubleNear(0.02, 1e-12), 50));
}

TEST_F(Table, TimesAlwaysGrowHoweverManyAreRepeated) {
  std::mt19937 random(3);
  std::string text = "t_s,gyro_z_lsb\n";
  for (int i = 0, stamp = 0; i < 50'000; ++i) {
    if (random() % 3 != 0 || i % 1000 > 900) stamp += i % 1000 == 0 ? 100 : 1;
    text += std::to_string(stamp) + "," + std::to_string(random() % 4) + "\n";
  }
  const std::vector<double> times = Times(Read(text));
  EXPECT_GT(times.size(), 40'000u);
  EXPECT_EQ(std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()), times.end());
}

TEST_F(Table, TimeThatGoesBackwardsIsAnErrorThatNamesTheLine) {
  EXPECT_THAT(ErrorOf("t_s,gyro_z_lsb\n0,1\n2,1\n1,1\n"),
              HasSubstr("table.csv:4: time goes backwards: t_s = 1 after 2"));
}

TEST_F(Table, WhatCannotBeReadIsCountedByKindWithThePlaceOfTheFirst) {
  const KeepingSink sink = Read(
      "t_s,gyro_x_lsb,gyro_z_lsb\n"
      "0,1,2\n"
      "1,1\n"        // ragged
      "2,1,2,3\n"    // ragged
      "3,abc,2\n"    // unparsable
      "4,nan,NaN\n"  // not a number, in two columns
      ",1,2\n"       // no time
      "5,1e999,-inf\n"
      "6,1..2,7\n"
      "7,8,9\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 3, 6, 7));
  EXPECT_EQ(sink.Count("ragged_line"), 2);
  EXPECT_EQ(sink.Where("ragged_line"), "line 3: 2 fields, expected 3");
  EXPECT_EQ(sink.Count("unparsable"), 3);
  EXPECT_EQ(sink.Where("unparsable"), "line 5, column gyro_x_lsb: 'abc'");
  EXPECT_EQ(sink.Count("not_a_number"), 3);
  EXPECT_EQ(sink.Count("no_time"), 1);
  EXPECT_TRUE(std::isnan(sink.gyro[1].xi[0]));
  EXPECT_EQ(sink.gyro[1].xi[2], 2);
  for (const Defect& defect : sink.defects)
    EXPECT_FALSE(std::isnan(defect.first_t_s)) << defect.kind;
}

// One damaged stamp must not cost the lines after it, nor a damaged number every sum it enters.
TEST_F(Table, TimesAndNumbersBeyondAllMeasurementsAreLeftOut) {
  const KeepingSink sink =
      Read("t_s,gyro_z_lsb,ref_inner_deg\n0,1,0\n1e20,2,0\n-1e12,3,0\n1,1e200,4\n2,5,-1e31\n");
  EXPECT_THAT(Times(sink), ElementsAre(0, 2));
  EXPECT_EQ(sink.Count("no_time"), 2);
  EXPECT_EQ(sink.Where("no_time"), "line 3");
  EXPECT_EQ(sink.Count("not_a_number"), 2);
  EXPECT_EQ(sink.angles.size(), 2u);
}

TEST_F(Table, ALineTooLongForTheBufferIsLeftOutAndCounted) {
  const std::string text = "t_s,gyro_z_lsb\n0,1\n1," + std::string(1'000'000, '7') + "\n2,3\n";
  const KeepingSink sink = Read(text);
  EXPECT_THAT(Times(sink), ElementsAre(0, 2));
  EXPECT_EQ(sink.Count("line_too_long"), 1);
  EXPECT_EQ(sink.Where("line_too_long"), "line 3");
  EXPECT_THAT(Times(Read("t_s,gyro_z_lsb\n0,1\n1," + std::string(1'000'000, '7'))), ElementsAre(0));
}

TEST_F(Table, AnOrientationNeedsAllItsPartsAndIsMadeToLengthOne) {
  const KeepingSink sink = Read(
      "t_s,gyro_z_lsb,ref_qw,ref_qx,ref_qy,ref_qz\n0,1,1.001,0,0,0\n1,1,,,,\n2,1,1,0,,0\n3,1,2,0,0,"
      "0\n");
  ASSERT_EQ(sink.orientations.size(), 1u);
  EXPECT_THAT(sink.orientations[0].q_wxyz, ElementsAre(1, 0, 0, 0));
  EXPECT_EQ(sink.Count("bad_quaternion"), 2);
}

TEST_F(Table, ValuesWithoutAGyroInTheRowAreCountedNotDroppedInSilence) {
  const KeepingSink sink = Read("t_s,gyro_z_lsb,temp_degC\n0,1,20\n1,,21\n");
  EXPECT_EQ(sink.gyro.size(), 1u);
  EXPECT_EQ(sink.Count("no_gyro"), 1);
}

std::string ManyRows(int count) {
  std::ostringstream text;
  text << "t_s,gyro_z_lsb\n";
  for (int i = 0; i < count; ++i) text << i * 0.005 << ',' << i * 7919 % 30000 << '\n';
  return text.str();
}

TEST_F(Table, GzipIsToldByItsBytesAndReadLikeThePlainText) {
  const std::string text = ManyRows(100'000);
  const KeepingSink plain = Read(text);
  const std::string half = text.substr(0, text.size() / 2);
  for (const std::string& bytes :
       {Gzip(text), Gzip(half) + Gzip(text.substr(half.size())) + std::string(100, '\0')}) {
    const KeepingSink packed = Read(bytes);
    EXPECT_EQ(Times(packed), Times(plain));
    EXPECT_TRUE(packed.defects.empty());
  }
}

TEST_F(Table, ATruncatedGzipIsReadToItsLastWholeLineAndNamedByByte) {
  const std::string packed = Gzip(ManyRows(100'000));
  const KeepingSink whole = Read(packed);
  const KeepingSink cut = Read(packed.substr(0, packed.size() / 2));
  EXPECT_GT(cut.gyro.size(), 30'000u);
  EXPECT_LT(cut.gyro.size(), 70'000u);
  for (std::size_t i = 0; i < cut.gyro.size(); ++i)
    ASSERT_EQ(cut.gyro[i].xi[2], whole.gyro[i].xi[2]);
  EXPECT_EQ(cut.Count("truncated_gzip"), 1);
  EXPECT_EQ(cut.Where("truncated_gzip"),
            "byte " + std::to_string(packed.size() / 2) + ": the compressed data end too soon");
  EXPECT_THAT(ErrorOf(packed.substr(0, 5)), HasSubstr("truncated_gzip"));
}

TEST_F(Table, AFlippedBitInAGzipIsFoundByItsChecksum) {
  std::string packed = Gzip(ManyRows(1000));
  packed[packed.size() - 6] ^= 1;  // in the checksum: the data before it are whole
  const KeepingSink sink = Read(packed);
  EXPECT_EQ(sink.gyro.size(), 1000u);
  EXPECT_EQ(sink.Count("damaged_gzip"), 1);
}

std::filesystem::path Dataset(const std::string& name) {
  return std::filesystem::path(GYROBENCH_SOURCE_DIR).parent_path() / "shared" / "datasets" / name;
}

// Counts by an independent reader (pandas): rows, repeated stamps (all of them doubled rows), lost
// orientations.
TEST(RealTables, GiveTheCountsThatAnIndependentReaderFinds) {
  struct Expected {
    const char* name;
    std::size_t rows;
    std::int64_t repeated;
    std::size_t orientations_lost;
  };
  for (const Expected& expected : {Expected{"stepper-encoder-z-slow.csv.gz", 149'827, 26, 0},
                                   Expected{"stepper-encoder-z-medium.csv.gz", 149'831, 27, 0},
                                   Expected{"stepper-encoder-y-slow.csv.gz", 149'829, 18, 0},
                                   Expected{"mocap-hand-slow.csv.gz", 56'940, 0, 648 / 4},
                                   Expected{"poses-0.csv.gz", 15'969, 0, 0}}) {
    if (!std::filesystem::exists(Dataset(expected.name))) {
      GTEST_SKIP() << Dataset(expected.name) << " is not here";
    }
    KeepingSink sink;
    Replay(Dataset(expected.name), sink);
    EXPECT_EQ(sink.gyro.size(), expected.rows - static_cast<std::size_t>(expected.repeated));
    EXPECT_EQ(sink.Count("repeated_time"), expected.repeated) << expected.name;
    if (sink.info.reference == ReferenceKind::kSensorAngle) {
      EXPECT_EQ(sink.angles.size(), sink.gyro.size());
    }
    if (sink.info.reference == ReferenceKind::kOrientation) {
      EXPECT_EQ(sink.orientations.size(), expected.rows - expected.orientations_lost);
    }
    EXPECT_EQ(sink.defects.size(), expected.repeated > 0 ? 1u : 0u) << expected.name;
  }
}

}  // namespace
}  // namespace gyrobench::recording
