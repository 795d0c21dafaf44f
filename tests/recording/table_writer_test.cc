#include "recording/table_writer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <iterator>

#include "base/error.h"
#include "record_builder.h"
#include "recording/replay.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using testing::HasSubstr;

constexpr double kTimeRounding_s =
    1e-9;  // times are whole microseconds: only the last bit may differ
constexpr double kRounding = 0.5001e-9;

bool Same(double a, double b, double tolerance) {
  return (std::isnan(a) && std::isnan(b)) || std::abs(a - b) <= tolerance;
}

void ExpectSame(const GyroSample& a, const GyroSample& b) {
  EXPECT_NEAR(a.t_s, b.t_s, kTimeRounding_s);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(Same(a.xi[i], b.xi[i], 0.0)) << a.xi[i] << " " << b.xi[i];
    EXPECT_TRUE(Same(a.accel_g[i], b.accel_g[i], kRounding)) << a.accel_g[i] << " " << b.accel_g[i];
  }
  EXPECT_TRUE(Same(a.temperature_degC, b.temperature_degC, kRounding));
}

void ExpectSameEvents(const KeepingSink& a, const KeepingSink& b) {
  ASSERT_EQ(a.gyro.size(), b.gyro.size());
  for (std::size_t i = 0; i < a.gyro.size(); ++i) ExpectSame(a.gyro[i], b.gyro[i]);
  ASSERT_EQ(a.angles.size(), b.angles.size());
  for (std::size_t i = 0; i < a.angles.size(); ++i) {
    EXPECT_EQ(a.angles[i].axis, b.angles[i].axis);
    EXPECT_NEAR(a.angles[i].t_s, b.angles[i].t_s, kTimeRounding_s);
    EXPECT_NEAR(a.angles[i].angle_deg, b.angles[i].angle_deg, kRounding);
  }
  ASSERT_EQ(a.ticks.size(), b.ticks.size());
  for (std::size_t i = 0; i < a.ticks.size(); ++i) {
    EXPECT_NEAR(a.ticks[i].host_s, b.ticks[i].host_s, kTimeRounding_s);
    EXPECT_NEAR(a.ticks[i].tick_s, b.ticks[i].tick_s, kRounding);
  }
  ASSERT_EQ(a.segments.size(), b.segments.size());
  for (std::size_t i = 0; i < a.segments.size(); ++i) {
    EXPECT_NEAR(a.segments[i].begin_s, b.segments[i].begin_s, kTimeRounding_s);
    EXPECT_NEAR(a.segments[i].end_s, b.segments[i].end_s, kTimeRounding_s);
    EXPECT_EQ(a.segments[i].kind, b.segments[i].kind);
    EXPECT_EQ(a.segments[i].name, b.segments[i].name);
  }
}

KeepingSink ReplayOf(const std::filesystem::path& path) {
  KeepingSink sink;
  Replay(path, sink);
  return sink;
}

// The law of the export: nothing that the analysis sees is changed by the way through text.
TEST(TableWriter, ATableOfARecordGivesTheRecordsEventsAgain) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  const KeepingSink record = ReplayOf(folder / "run");
  for (const char* name : {"table.csv", "table.csv.gz"}) {
    const TableSummary summary = ExportTable(folder / "run", folder / name);
    EXPECT_EQ(summary.late, 0);
    EXPECT_EQ(summary.unannounced, 0);
    const KeepingSink table = ReplayOf(folder / name);
    ExpectSameEvents(record, table);
    EXPECT_TRUE(table.defects.empty());
    EXPECT_EQ(table.info.geometry, record.info.geometry);
    EXPECT_EQ(table.info.site_latitude_deg, record.info.site_latitude_deg);
    EXPECT_EQ(table.info.site_heading_deg, record.info.site_heading_deg);
    EXPECT_EQ(table.info.gyro_units_per_deg_s, record.info.gyro_units_per_deg_s);
    EXPECT_EQ(table.info.gear_ratio, record.info.gear_ratio);
    EXPECT_EQ(table.info.stop_accuracy_deg, record.info.stop_accuracy_deg);
    EXPECT_EQ(table.info.gyro_delay_s, record.info.gyro_delay_s);
    EXPECT_EQ(table.info.reference_delay_s, record.info.reference_delay_s);
    EXPECT_EQ(table.info.sensor, record.info.sensor);
    EXPECT_EQ(table.info.power_on, record.info.power_on);
    EXPECT_EQ(table.info.notes, record.info.notes);
    EXPECT_EQ(table.info.stand_axis_present, record.info.stand_axis_present);
    EXPECT_EQ(table.info.accel_present, record.info.accel_present);
    EXPECT_TRUE(table.info.covariates.empty());
  }
}

TEST(TableWriter, AnExportThatIsStoppedLeavesNothingBehind) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  for (const double stop : {0.0, 0.4, 0.9}) {
    const auto export_until = [&] {
      ExportTable(folder / "run", folder / "table.csv", [&](double fraction) {
        if (fraction >= stop) throw Error("stopped");
      });
    };
    EXPECT_THAT(export_until, testing::ThrowsMessage<Error>(HasSubstr("stopped")));
    const std::filesystem::directory_iterator left(folder.path());
    EXPECT_EQ(std::distance(begin(left), end(left)), 1);  // the record
  }
}

TEST(TableWriter, ATableOfARecordInWhichTheUnitRestartedNamesNoPowerOn) {
  const TemporaryFolder folder;
  RecordPlan plan;
  plan.restart_at_block = 50;
  BuildRecord(folder / "run", plan);
  ExportTable(folder / "run", folder / "table.csv");
  EXPECT_EQ(ReplayOf(folder / "table.csv").info.power_on, "");
  EXPECT_THAT(ReadFile(folder / "table.csv"), HasSubstr("# defect = unit_restarted 1"));
}

TEST(TableWriter, ATableOfATableIsTheSameText) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  ExportTable(folder / "run", folder / "a.csv");
  ExportTable(folder / "a.csv", folder / "b.csv");
  EXPECT_EQ(ReadFile(folder / "a.csv"), ReadFile(folder / "b.csv"));
}

TEST(TableWriter, DefectsOfARecordGoAlongWithItsTable) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  const std::string log = ReadFile(folder / "run/events.lcmlog");
  WriteFile(folder / "run/events.lcmlog", log.substr(0, log.size() - 500));
  const KeepingSink record = ReplayOf(folder / "run");
  ASSERT_FALSE(record.defects.empty());
  ExportTable(folder / "run", folder / "table.csv");
  const KeepingSink table = ReplayOf(folder / "table.csv");
  ASSERT_EQ(table.defects.size(), record.defects.size());
  EXPECT_EQ(table.defects[0].kind, record.defects[0].kind);
  EXPECT_EQ(table.defects[0].count, record.defects[0].count);
  EXPECT_EQ(table.defects[0].where, record.defects[0].where);
}

class WriterOfAll : public testing::Test {
 protected:
  MeasurementInfo Info(ReferenceKind reference) const {
    MeasurementInfo info;
    info.gyro_present = {true, true, true};
    info.gyro_unit = RateUnit::kDegPerSecond;
    info.reference = reference;
    info.reference_axis = SensorAxis::kY;
    info.stand_axis_present = {true, true, true};
    return info;
  }
  TemporaryFolder folder_;
};

TEST_F(WriterOfAll, OtherUnitsAndReferencesComeBackToo) {
  for (const ReferenceKind reference :
       {ReferenceKind::kSensorAngle, ReferenceKind::kOrientation, ReferenceKind::kNone}) {
    TableWriter writer(folder_ / "t.csv");
    writer.OnInfo(Info(reference));
    writer.OnGyro({-0.5, {0.123456789, -1234567.25, kMissing}, {}, kMissing});
    if (reference == ReferenceKind::kSensorAngle) writer.OnAngle({0.0, 1, -12.5});
    if (reference == ReferenceKind::kOrientation)
      writer.OnOrientation({0.0, {0.5, -0.5, 0.5, -0.5}});
    writer.OnTickPair({0.25, 0.25});
    EXPECT_EQ(writer.Close().rows, reference == ReferenceKind::kNone ? 2 : 3);
    const KeepingSink sink = ReplayOf(folder_ / "t.csv");
    EXPECT_EQ(sink.info.reference, reference);
    EXPECT_EQ(sink.info.gyro_unit, RateUnit::kDegPerSecond);
    ASSERT_EQ(sink.gyro.size(), 1u);
    EXPECT_EQ(sink.gyro[0].t_s, -0.5);
    EXPECT_EQ(sink.gyro[0].xi[0], 0.123456789);
    EXPECT_EQ(sink.gyro[0].xi[1], -1234567.25);
    EXPECT_TRUE(std::isnan(sink.gyro[0].xi[2]));
    EXPECT_EQ(sink.angles.size(), reference == ReferenceKind::kSensorAngle ? 1u : 0u);
    EXPECT_EQ(sink.orientations.size(), reference == ReferenceKind::kOrientation ? 1u : 0u);
  }
}

TEST_F(WriterOfAll, EventsOfPolledDevicesAreWrittenInOrderOfTime) {
  TableWriter writer(folder_ / "t.csv");
  writer.OnInfo(Info(ReferenceKind::kStandAngles));
  constexpr int kBlocks = 400;
  for (int block = 0; block < kBlocks; ++block) {
    // The angles of a second are heard before the samples of it.
    for (int i = 0; i < 50; ++i) writer.OnAngle({block + i * 0.02, i % 3, 1.0 * i});
    for (int i = 0; i < 100; ++i) writer.OnGyro({block + i * 0.01, {1.0 * i, 0, 0}, {}, 20.0});
  }
  const TableSummary summary = writer.Close();
  EXPECT_EQ(summary.late, 0);
  EXPECT_EQ(summary.rows, kBlocks * 100) << "an angle at the time of a sample shares its row";
  const KeepingSink sink = ReplayOf(folder_ / "t.csv");  // throws where time goes backwards
  EXPECT_EQ(sink.gyro.size(), 100u * kBlocks);
  EXPECT_EQ(sink.angles.size(), 50u * kBlocks);
}

TEST_F(WriterOfAll, WhatComesTooLateOrUnannouncedIsCounted) {
  TableWriter writer(folder_ / "t.csv");
  writer.OnInfo(Info(ReferenceKind::kSensorAngle));
  for (int i = 0; i < 100; ++i) writer.OnGyro({i * 1.0, {1, 2, 3}, {}, kMissing});
  writer.OnAngle({1.0, 1, 5.0});
  writer.OnAngle({99.0, 0, 5.0});
  const TableSummary summary = writer.Close();
  EXPECT_EQ(summary.late, 1);
  EXPECT_EQ(summary.unannounced, 1);
}

// More covariates than one event of the writer holds, numbers that 9 decimals would spoil, gaps.
TEST_F(WriterOfAll, CovariatesOfATableComeBackToTheLastDigit) {
  constexpr int kCovariates = 10;
  std::string text = "t_s,gyro_z_lsb";
  for (int i = 0; i < kCovariates; ++i) text += ",extra_" + std::to_string(i);
  for (int row = 0; row < 40; ++row) {
    text += "\n" + std::to_string(row) + "," + (row % 5 == 4 ? "" : std::to_string(row));
    for (int i = 0; i < kCovariates; ++i) {
      text += (row + i) % 3 == 0 ? "," : "," + std::to_string(row * 7 + i) + "e-13";
    }
  }
  WriteFile(folder_ / "in.csv", text + "\n");
  const KeepingSink in = ReplayOf(folder_ / "in.csv");
  ExportTable(folder_ / "in.csv", folder_ / "out.csv");
  const KeepingSink out = ReplayOf(folder_ / "out.csv");
  EXPECT_EQ(out.info.covariates, in.info.covariates);
  EXPECT_EQ(out.gyro.size(), in.gyro.size());
  EXPECT_EQ(out.covariate_times_s, in.covariate_times_s);
  ASSERT_EQ(out.covariates.size(), 40u);
  for (std::size_t row = 0; row < 40; ++row) {
    for (std::size_t i = 0; i < kCovariates; ++i) {
      EXPECT_TRUE(Same(out.covariates[row][i], in.covariates[row][i], 0.0)) << row << " " << i;
    }
  }
}

TEST_F(WriterOfAll, WithoutCloseNothingIsLeftBehind) {
  {
    TableWriter writer(folder_ / "t.csv");
    writer.OnInfo(Info(ReferenceKind::kNone));
    writer.OnGyro({0.0, {1, 2, 3}, {}, kMissing});
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(WriterOfAll, NamesThatSayNoFormAndFoldersThatAreNotThereAreErrors) {
  EXPECT_THAT(MessageOf<DataError>([&] { TableWriter writer(folder_ / "t.txt"); }),
              HasSubstr("ends in .csv or .csv.gz"));
  EXPECT_THAT(MessageOf<DataError>([&] { TableWriter writer(folder_ / "none/t.csv"); }),
              HasSubstr("No such file or directory"));
}

TEST_F(WriterOfAll, AFullDiskIsAnErrorAndLeavesNoHalfTable) {
  rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 100'000;
  setrlimit(RLIMIT_FSIZE, &small);
  std::string message;
  {
    TableWriter writer(folder_ / "t.csv");
    writer.OnInfo(Info(ReferenceKind::kNone));
    message = MessageOf<DataError>([&] {
      for (int i = 0; i < 100'000; ++i) writer.OnGyro({i * 0.01, {1, 2, 3}, {}, kMissing});
      writer.Close();
    });
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  EXPECT_THAT(message, HasSubstr("File too large"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

}  // namespace
}  // namespace gyrobench::recording
