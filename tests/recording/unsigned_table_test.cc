// Tables of unsigned converters: their zero is taken off where samples enter, and where nobody gave
// it, that is said.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/error.h"
#include "base/unsigned_counts.h"
#include "recording/replay.h"
#include "recording/table_writer.h"
#include "tests/recording/sinks.h"

namespace gyrobench::recording {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class UnsignedTable : public testing::Test {
 protected:
  KeepingSink Read(const std::string& text) {
    WriteFile(folder_ / "table.csv", text);
    KeepingSink sink;
    ReplayTable(folder_ / "table.csv", sink);
    return sink;
  }
  std::string ErrorOf(const std::string& text) {
    return MessageOf<DataError>([&] { Read(text); });
  }
  // Rows of noise about `zero`, of three axes, with a swing of `swing` counts.
  std::string Rows(double zero, double swing) {
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0.0, 20.0);
    std::string rows = "t_s,gyro_x_lsb,gyro_y_lsb,gyro_z_lsb,accel_x_lsb,accel_y_lsb,accel_z_lsb\n";
    for (int i = 0; i < 400; ++i) {
      rows += std::to_string(0.01 * i);
      for (int c = 0; c < 6; ++c) {
        const double turned = i % 100 > 80 ? swing * (i % 100 - 80) / 20.0 : 0.0;
        rows += "," + std::to_string(std::lround(zero + turned + noise(random)));
      }
      rows += "\n";
    }
    return rows;
  }
  TemporaryFolder folder_;
};

TEST_F(UnsignedTable, HasItsZeroTakenOffWhereSamplesEnter) {
  const KeepingSink sink = Read(
      "# gyro_lsb_per_deg_s = 131\n# gyro_lsb_zero = 32768\n# accel_lsb_per_g = 4096\n"
      "# accel_lsb_zero = 32760\n"
      "t_s,gyro_x_lsb,gyro_z_lsb,accel_z_lsb\n0,32770,32000,36856\n");
  ASSERT_EQ(sink.gyro.size(), 1u);
  EXPECT_EQ(sink.gyro[0].xi[0], 2.0);
  EXPECT_EQ(sink.gyro[0].xi[2], -768.0);
  EXPECT_EQ(sink.gyro[0].accel_g[2], 1.0);
  EXPECT_EQ(sink.info.gyro_lsb_zero, 32768.0);
  EXPECT_EQ(sink.info.accel_lsb_zero, 32760.0);
  EXPECT_EQ(sink.info.key_lines.at("gyro_lsb_zero"), 2);
  EXPECT_EQ(sink.info.first_row_line, 6);
}

TEST_F(UnsignedTable, IsWrittenAgainAsItWas) {
  const std::string head = "# gyro_lsb_per_deg_s = 131\n# gyro_lsb_zero = 32768\n";
  const KeepingSink first = Read(head + "t_s,gyro_x_lsb\n0.5,32770\n1,0\n");
  ExportTable(folder_ / "table.csv", folder_ / "again.csv");
  const std::string text = ReadFile(folder_ / "again.csv");
  EXPECT_THAT(text, AllOf(HasSubstr("# gyro_lsb_zero = 32768"), HasSubstr("32770")));
  KeepingSink again;
  ReplayTable(folder_ / "again.csv", again);
  ASSERT_EQ(again.gyro.size(), 2u);
  EXPECT_EQ(again.gyro[0].xi[0], first.gyro[0].xi[0]);
  EXPECT_EQ(again.gyro[1].xi[0], -32768.0);
}

TEST_F(UnsignedTable, IsRecognisedWithoutTheKeyAndSaidOnce) {
  const std::string keys = "# gyro_lsb_per_deg_s = 131\n# accel_lsb_per_g = 4096\n";
  const KeepingSink raw = Read(keys + Rows(32768, 9000));
  EXPECT_EQ(raw.Where("unsigned_counts"), "gyro_x_lsb, gyro_y_lsb, gyro_z_lsb");
  ASSERT_EQ(raw.defects.size(), 2u);
  EXPECT_EQ(raw.defects[1].where, "accel_x_lsb, accel_y_lsb, accel_z_lsb");
  const KeepingSink said =
      Read("# gyro_lsb_zero = 32768\n# accel_lsb_zero = 32768\n" + keys + Rows(32768, 9000));
  EXPECT_TRUE(said.defects.empty());
  Read(keys + Rows(32768, 9000));
  ExportTable(folder_ / "table.csv", folder_ / "again.csv");
  KeepingSink again;
  ReplayTable(folder_ / "again.csv", again);
  EXPECT_EQ(std::count_if(again.defects.begin(), again.defects.end(),
                          [](const Defect& d) { return d.where.starts_with("gyro"); }),
            1);
}

TEST_F(UnsignedTable, IsNotSeenInSignedCounts) {
  EXPECT_EQ(Read(Rows(0, 9000)).Count("unsigned_counts"), 0);
  EXPECT_EQ(Read(Rows(0, 60000)).Count("unsigned_counts"), 0) << "wider than 16 bits";
  EXPECT_EQ(Read(Rows(200, 60000)).Count("unsigned_counts"), 0) << "wider, and never below zero";
  EXPECT_EQ(Read(Rows(0, 9e6)).Count("unsigned_counts"), 0);
}

TEST_F(UnsignedTable, KeysOfTheReferenceAreReadAndWritten) {
  const std::string head =
      "# ref_scale_uncertainty = 0.0002\n# ref_eccentricity_deg = 0.01\n# ref_alignment_deg = "
      "0.3\n";
  const KeepingSink sink = Read(head + "t_s,gyro_z_lsb,ref_inner_deg\n0,1,2\n");
  const ReferenceUncertainty expected = {0.0002, 0.01, 0.3};
  EXPECT_EQ(sink.info.reference_uncertainty, expected);
  ExportTable(folder_ / "table.csv", folder_ / "again.csv");
  KeepingSink again;
  ReplayTable(folder_ / "again.csv", again);
  EXPECT_EQ(again.info.reference_uncertainty, expected);
}

TEST_F(UnsignedTable, MistakesInTheHeadNameTheLineAndTheRightWord) {
  EXPECT_THAT(ErrorOf("# gyro_lsb_zero = -1\nt_s,gyro_z_lsb\n"),
              HasSubstr("table.csv:1: gyro_lsb_zero = -1: expected a number 0 .. "));
  EXPECT_THAT(ErrorOf("# ref_scale_uncertainty = 5 ppm\nt_s,gyro_z_lsb\n"),
              HasSubstr("table.csv:1: ref_scale_uncertainty = 5 ppm: expected a number 0 .. 0.1"));
  EXPECT_THAT(ErrorOf("# sensor = 1\n# gyro_lsb_zeros = 1\nt_s,gyro_z_lsb\n"),
              HasSubstr("table.csv:2: unknown key gyro_lsb_zeros: did you mean gyro_lsb_"));
  EXPECT_THAT(ErrorOf("t_s,gyro_z_lsb,temperature\n"),
              HasSubstr("table.csv:1: column temperature: did you mean temp_degC?"));
  EXPECT_THAT(ErrorOf("t_s,gyro_x_lsb,gyro_z_dps\n"), HasSubstr("did you mean gyro_z_deg_s?"));
  EXPECT_THAT(Read("t_s,gyro_z_lsb,supply_v,humidity,motor_current_a\n0,1,2,3,4\n").info.covariates,
              ElementsAre("supply_v", "humidity", "motor_current_a"));
}

}  // namespace
}  // namespace gyrobench::recording
