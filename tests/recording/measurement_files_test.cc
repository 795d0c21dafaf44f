#include "recording/measurement_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/error.h"
#include "record_builder.h"
#include "recording/run_directory.h"
#include "sinks.h"

namespace gyrobench::recording {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(MeasurementFiles, ARecordIsTheSameByWhateverFileOfItIsNamed) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  const auto log = folder / "run" / kEventLogName, json = folder / "run" / kRunJsonName;
  for (const auto& path : {folder / "run", log, json}) {
    const MeasurementFiles found = FilesOfMeasurement(path);
    EXPECT_TRUE(found.is_record) << path;
    EXPECT_EQ(found.folder, folder / "run");
    EXPECT_THAT(found.files, ElementsAre(log, json)) << path;
  }
}

TEST(MeasurementFiles, ALogOfAnyNameIsToldByItsFirstBytesATableByItsName) {
  const TemporaryFolder folder;
  BuildRecord(folder / "run", {});
  std::filesystem::rename(folder / "run/events.lcmlog", folder / "run/elsewhere.00");
  const MeasurementFiles log = FilesOfMeasurement(folder / "run/elsewhere.00");
  EXPECT_TRUE(log.is_record);
  EXPECT_THAT(log.files, ElementsAre(folder / "run/elsewhere.00", folder / "run/run.json"));
  std::filesystem::copy(folder / "run/elsewhere.00", folder / "run/table.csv");
  const MeasurementFiles table = FilesOfMeasurement(folder / "run/table.csv");
  EXPECT_FALSE(table.is_record);
  EXPECT_EQ(table.folder, folder / "run");
  EXPECT_THAT(table.files, ElementsAre(folder / "run/table.csv"));
}

TEST(MeasurementFiles, AnEmptyFolderIsARecordWithoutFilesAndWhatIsAbsentIsAnError) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "empty");
  EXPECT_THAT(FilesOfMeasurement(folder / "empty").files, IsEmpty());
  EXPECT_FALSE(IsRecordFolder(folder / "empty"));
  EXPECT_THROW(FilesOfMeasurement(folder / "absent"), DataError);
}

}  // namespace
}  // namespace gyrobench::recording
