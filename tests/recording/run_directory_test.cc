#include "recording/run_directory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "record_builder.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr Utime kStart = 1'795'275'012'000'000;  // 2026-11-21 15:30:12 UTC

std::vector<std::string> Files(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

void Touch(const RunDirectory& run, int age_s) {
  WriteFile(run.EventLog(), "");
  fs::last_write_time(run.EventLog(),
                      fs::file_time_type::clock::now() - std::chrono::seconds(age_s));
}

TEST(RunDirectory, TheRunsNameIsUtcAndTheProcedureAndNeverTakenTwice) {
  const TemporaryFolder folder;
  EXPECT_EQ(RunDirectory::Create(folder / "a/b", "scale", kStart).run_id(),
            "20261121-153012-scale");
  EXPECT_EQ(RunDirectory::Create(folder / "a/b", "scale", kStart).run_id(),
            "20261121-153012-scale-02");
  EXPECT_EQ(RunDirectory::Create(folder / "a/b", "../x y", kStart).run_id(),
            "20261121-153012-___x_y");
  EXPECT_EQ(Files(folder / "a/b").size(), 3u);
}

TEST(RunDirectory, AFolderThatCannotBeMadeOrWrittenIsAnErrorWithTheMend) {
  const TemporaryFolder folder;
  WriteFile(folder / "file", "");
  EXPECT_THAT(MessageOf<DataError>([&] { RunDirectory::Create(folder / "file", "scale", kStart); }),
              HasSubstr("set `records` in the stand file"));
  if (geteuid() == 0) return;  // root may write everywhere
  fs::create_directory(folder / "closed");
  fs::permissions(folder / "closed", fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THAT(
      MessageOf<DataError>([&] { RunDirectory::Create(folder / "closed", "scale", kStart); }),
      HasSubstr("Permission denied"));
}

// What a killed daemon left is told from what a living one makes.
TEST(RunDirectory, IsBeingMadeForAsLongAsItsMakerLives) {
  const TemporaryFolder folder;
  auto made = std::make_unique<RunDirectory>(RunDirectory::Create(folder.path(), "scale", kStart));
  made->WriteRun({{kOutcomeKey, kRunningOutcome}});
  const RunDirectory seen = RunDirectory::Open(made->folder());
  EXPECT_TRUE(seen.IsBeingMade());
  const RunDirectory copy = *made;
  made.reset();
  EXPECT_TRUE(copy.IsBeingMade());
  EXPECT_TRUE(seen.IsBeingMade());
}

TEST(RunDirectory, IsNotBeingMadeOnceItsMakerIsGone) {
  const TemporaryFolder folder;
  const fs::path record = RunDirectory::Create(folder.path(), "scale", kStart).folder();
  WriteFile(record / "run.json", "{}");
  EXPECT_FALSE(RunDirectory::Open(record).IsBeingMade());
  EXPECT_FALSE(RunDirectory::Open(record).IsBeingMade()) << "a reader holds nothing";
}

TEST(RunDirectory, JsonIsReplacedWholeAndLeavesNoOtherFile) {
  const TemporaryFolder folder;
  const RunDirectory run = RunDirectory::Create(folder.path(), "scale", kStart);
  run.WriteRun({{"outcome", ""}});
  run.WriteRun({{"outcome", "done"}, {"name", "bytes \xff that are no text"}});
  EXPECT_EQ(run.ReadRun()["outcome"], "done");
  EXPECT_EQ(Files(run.folder()), std::vector<std::string>{"run.json"});
}

TEST(RunDirectory, JsonThatCannotBeReadIsNamedByFileAndByte) {
  const TemporaryFolder folder;
  WriteFile(folder / "run.json", "{\"a\": 1,");
  const RunDirectory run = RunDirectory::Open(folder.path());
  EXPECT_THAT(MessageOf<DataError>([&] { run.ReadRun(); }),
              HasSubstr("run.json: no valid JSON at byte 9"));
  EXPECT_THAT(MessageOf<DataError>([&] { run.ReadResult(); }), HasSubstr("No such file"));
  WriteFile(folder / "run.json", "{\"a\": 1e999}");
  EXPECT_THAT(MessageOf<DataError>([&] { run.ReadRun(); }), HasSubstr("run.json: no usable JSON"));
  WriteFile(folder / "run.json", std::string(200'000, '['));
  EXPECT_THAT(MessageOf<DataError>([&] { run.ReadRun(); }), HasSubstr("nested deeper than"));
  EXPECT_THAT(MessageOf<DataError>([&] { WriteJsonAtomically(folder / "none/x.json", {}); }),
              HasSubstr("cannot be written"));
}

TEST(RunDirectory, FindsARunByIdBeginningPathAndAsTheLatest) {
  const TemporaryFolder folder;
  const RunDirectory a = RunDirectory::Create(folder.path(), "bias", kStart);
  const RunDirectory b = RunDirectory::Create(folder.path(), "scale", kStart + 60'000'000);
  const RunDirectory c = RunDirectory::Create(folder.path(), "scale", kStart + 60'000'000);
  fs::create_directory(folder / "no-record");
  Touch(a, 10);
  Touch(b, 300);  // a virtual clock may name runs of later times before
  Touch(c, 20);
  const auto find = [&](const std::string& name) { return FindRun(folder.path(), name).run_id(); };
  EXPECT_EQ(ListRuns(folder.path()).size(), 3u);
  EXPECT_EQ(find("latest"), a.run_id());
  EXPECT_EQ(find("20261121-153012"), a.run_id());
  EXPECT_EQ(find(b.run_id()), b.run_id()) << "an id is also the beginning of the next one";
  EXPECT_EQ(find(c.folder().string()), c.run_id());
  EXPECT_EQ(find(c.EventLog().string()), c.run_id());
  EXPECT_THAT(MessageOf<DataError>([&] { find("2026"); }), HasSubstr("beginning of 3 records"));
  EXPECT_THAT(MessageOf<DataError>([&] { find("1999"); }), HasSubstr(c.run_id()));
}

TEST(RunDirectory, NoRecordsIsAnEmptyListAndNoLatest) {
  const TemporaryFolder folder;
  EXPECT_TRUE(ListRuns(folder / "none").empty());
  EXPECT_THAT(MessageOf<DataError>([&] { FindRun(folder / "none", "latest"); }),
              HasSubstr("no records yet"));
  EXPECT_THROW(RunDirectory::Open(folder.path()), DataError);
}

TEST(MeasurementInfoJson, IsUndoneByItsInverseForEveryField) {
  MeasurementInfo info = PlannedInfo({});
  info.gyro_unit = RateUnit::kRadPerSecond;
  info.gyro_present = {false, true, false};
  info.accel_present = {false, false, true};
  info.reference = ReferenceKind::kSensorAngle;
  info.reference_axis = SensorAxis::kY;
  info.covariates = {"supply_v", "fan"};
  info.power_on_utime = 1'795'000'000'123'457;
  info.gyro_lsb_zero = 32768.0;
  info.accel_lsb_zero = 32760.0;
  info.reference_uncertainty = {0.0001, 0.02, 0.3};
  for (const MeasurementInfo& in : {info, PlannedInfo({}), MeasurementInfo{}}) {
    const MeasurementInfo out = MeasurementInfoFromJson(nlohmann::json::parse(ToJson(in).dump()));
    EXPECT_EQ(out.source, in.source);
    EXPECT_EQ(out.gyro_unit, in.gyro_unit);
    EXPECT_EQ(out.gyro_present, in.gyro_present);
    EXPECT_EQ(out.accel_present, in.accel_present);
    EXPECT_EQ(out.temperature_present, in.temperature_present);
    EXPECT_EQ(out.gyro_units_per_deg_s, in.gyro_units_per_deg_s);
    EXPECT_EQ(out.gyro_lsb_zero, in.gyro_lsb_zero);
    EXPECT_EQ(out.accel_lsb_zero, in.accel_lsb_zero);
    EXPECT_EQ(out.reference_uncertainty, in.reference_uncertainty);
    EXPECT_EQ(out.reference, in.reference);
    EXPECT_EQ(out.stand_axis_present, in.stand_axis_present);
    EXPECT_EQ(out.reference_axis, in.reference_axis);
    EXPECT_EQ(out.geometry, in.geometry);
    EXPECT_EQ(out.site_latitude_deg, in.site_latitude_deg);
    EXPECT_EQ(out.site_heading_deg, in.site_heading_deg);
    EXPECT_EQ(out.gear_ratio, in.gear_ratio);
    EXPECT_EQ(out.stop_accuracy_deg, in.stop_accuracy_deg);
    EXPECT_EQ(out.gyro_delay_s, in.gyro_delay_s);
    EXPECT_EQ(out.reference_delay_s, in.reference_delay_s);
    EXPECT_EQ(out.sensor, in.sensor);
    EXPECT_EQ(out.power_on, in.power_on);
    EXPECT_EQ(out.power_on_utime, in.power_on_utime);
    EXPECT_EQ(out.notes, in.notes);
    EXPECT_EQ(out.covariates, in.covariates);
  }
}

TEST(MeasurementInfoJson, ARecordFromBeforeTheGeometryWasKeptIsOfThePerfectStand) {
  nlohmann::json json = ToJson(PlannedInfo({}));
  StandGeometry geometry;
  for (const GeometryAngle& angle : AnglesOf(geometry)) ASSERT_EQ(json.erase(angle.name), 1u);
  EXPECT_EQ(MeasurementInfoFromJson(json).geometry, StandGeometry{});
}

TEST(MeasurementInfoJson, AWrongValueIsNamedByKeyAndWhatWasExpected) {
  const auto read = [](const nlohmann::json& json) {
    return MessageOf<DataError>([&] { MeasurementInfoFromJson(json); });
  };
  EXPECT_THAT(read({{"gyro_unit", "furlongs"}}), HasSubstr("expected one of lsb, deg_s, rad_s"));
  EXPECT_THAT(read({{"gear_ratio", "forty"}}), HasSubstr("measurement.gear_ratio = \"forty\""));
  EXPECT_THAT(read({{"mount_x_deg", 181}}),
              HasSubstr("measurement.mount_x_deg = 181: expected a number -180 .. 180"));
  EXPECT_THAT(read({{"gyro_delay_s", -0.001}}),
              HasSubstr("measurement.gyro_delay_s = -0.001: expected a number 0 .. 1"));
  EXPECT_THAT(read({{"middle_inner_deg", nullptr}}), HasSubstr("measurement.middle_inner_deg"));
  EXPECT_THAT(read({{"gyro", {"x", 3}}}), HasSubstr("measurement.gyro"));
  EXPECT_THAT(read(nlohmann::json::array()), HasSubstr("expected an object"));
}

}  // namespace
}  // namespace gyrobench::recording
