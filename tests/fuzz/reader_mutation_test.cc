// Thousands of damaged files, the same in every run. The fuzzing targets of this folder look
// further; what they found is pinned down in the readers' own tests.
#include <gtest/gtest.h>

#include "tests/fuzz/allocation_meter.h"
#include "tests/fuzz/calibration_laws.h"
#include "tests/fuzz/laws.h"
#include "tests/fuzz/mutation.h"
#include "tests/fuzz/samples.h"
#include "tests/recording/gzip.h"
#include "tests/recording/record_builder.h"
#include "tests/recording/sinks.h"

namespace gyrobench::testing {
namespace {

namespace fs = std::filesystem;
using recording::Gzip;
using recording::ReadFile;
using recording::WriteFile;

constexpr std::size_t kMostBytes = 64u << 20;

class ReaderMutation : public ::testing::Test {
 protected:
  // Digests `path`; true when it was read. Bounds the memory.
  bool Reads(const fs::path& path, const std::string& what) {
    bool read = false;
    StartMeter();
    try {
      read = Digest(path).has_value();
    } catch (const std::exception& error) {
      ADD_FAILURE() << what << ": " << error.what();
      Keep(path);
    }
    EXPECT_LT(PeakBytes(), kMostBytes) << what;
    return read;
  }
  // What broke a law stays, for a debugger.
  static void Keep(const fs::path& path) {
    std::error_code ignored;
    fs::copy(path, fs::temp_directory_path() / "gyrobench-broken-law",
             fs::copy_options::recursive | fs::copy_options::overwrite_existing, ignored);
  }

  TemporaryFolder folder_;
  Random random_{20261121};
};

TEST_F(ReaderMutation, ValidSamplesAreReadWhole) {
  for (const NamedBytes& table : SampleTables()) {
    WriteFile(folder_ / "table.csv", table.bytes);
    const auto recording = Digest(folder_ / "table.csv");
    ASSERT_TRUE(recording) << table.name;
    EXPECT_GT(recording->columns.nodes.size(), 20u) << table.name;
    if (recording->info.reference != ReferenceKind::kNone) {
      EXPECT_GE(recording->columns.rests.size(), 1u) << table.name;
    }
    EXPECT_NO_THROW(DigestExported(folder_ / "table.csv", folder_.path())) << table.name;
  }
  MakeSampleRecord(folder_ / "run");
  ASSERT_TRUE(Digest(folder_ / "run"));
}

TEST_F(ReaderMutation, TablesGiveAnErrorThatNamesThemOrNumbers) {
  constexpr int kRounds = 1500;
  int read = 0;
  for (const NamedBytes& table : SampleTables()) {
    for (int round = 0; round < kRounds; ++round) {
      std::string text = table.bytes;
      for (unsigned i = random_() % 4; i < 4; ++i) {
        random_() % 3 == 0 ? MutateBytes(text, random_) : MutateTable(text, random_);
      }
      WriteFile(folder_ / "table.csv", text);
      read += Reads(folder_ / "table.csv", table.name) ? 1 : 0;
      if (round % 4 != 0) continue;
      EXPECT_NO_THROW(DigestExported(folder_ / "table.csv", folder_.path())) << round;
      if (HasFailure()) return Keep(folder_ / "table.csv");
    }
  }
  EXPECT_GT(read, kRounds) << "damage must leave something to look at";
}

TEST_F(ReaderMutation, CompressedTablesDoSoToo) {
  for (const NamedBytes& table : SampleTables()) {
    const std::string valid = Gzip(table.bytes);
    for (int round = 0; round < 500; ++round) {
      std::string bytes = valid;
      MutateBytes(bytes, random_);
      WriteFile(folder_ / "table.csv.gz", bytes);
      Reads(folder_ / "table.csv.gz", table.name);
    }
  }
}

TEST_F(ReaderMutation, RecordsGiveAnErrorThatNamesThemOrNumbers) {
  const SampleRecord valid = MakeSampleRecord(folder_ / "run");
  const std::string earlier = recording::WithoutChecksums(folder_ / "run/events.lcmlog");
  int read = 0;
  for (int round = 0; round < 3000; ++round) {
    // With checksums, damage does not come beyond them; without, as of earlier records, it does.
    std::string log = round % 3 == 0 ? valid.log : earlier;
    for (unsigned i = random_() % 4; i < 4; ++i) {
      random_() % 3 == 0 ? MutateBytes(log, random_) : MutateBinaryNumber(log, random_);
    }
    WriteFile(folder_ / "run/events.lcmlog", log);
    // With and without what run.json says.
    fs::remove(folder_ / "run/run.json");
    if (round % 2 == 0) WriteFile(folder_ / "run/run.json", valid.run_json);
    read += Reads(folder_ / "run", "log") ? 1 : 0;
  }
  EXPECT_GT(read, 1500);
}

TEST_F(ReaderMutation, AnyRunJsonLeavesTheLogReadable) {
  const SampleRecord valid = MakeSampleRecord(folder_ / "run");
  for (int round = 0; round < 2000; ++round) {
    std::string json = valid.run_json;
    random_() % 2 == 0 ? MutateBytes(json, random_) : MutateTextNumber(json, random_);
    WriteFile(folder_ / "run/run.json", json);
    Reads(folder_ / "run", json);
  }
}

TEST_F(ReaderMutation, CalibrationsAreReadOrRefusedByName) {
  const std::string valid = SampleCalibration();
  const fs::path file = folder_ / "calibration.json";
  WriteFile(file, valid);
  ASSERT_TRUE(DigestCalibration(file));
  int read = 0;
  for (int round = 0; round < 1500; ++round) {
    std::string text = valid;
    random_() % 4 == 0 ? MutateBytes(text, random_) : MutateTextNumber(text, random_);
    WriteFile(file, text);
    EXPECT_NO_THROW(read += DigestCalibration(file) ? 1 : 0) << text;
    if (HasFailure()) return;
  }
  EXPECT_GT(read, 100);
}

TEST_F(ReaderMutation, StandFilesAndScenariosAreReadOrRefusedByName) {
  const fs::path source = fs::path(GYROBENCH_SOURCE_DIR) / "config";
  fs::copy(source, folder_ / "config", fs::copy_options::recursive);
  int read = 0;
  for (const char* name :
       {"stand.toml", "one-axis.toml", "virtual.toml", "scenarios/typical.toml"}) {
    const std::string valid = ReadFile(source / name);
    const fs::path file = folder_ / "config" / name;
    for (int round = 0; round < 400; ++round) {
      std::string text = valid;
      random_() % 2 == 0 ? MutateBytes(text, random_) : MutateTextNumber(text, random_);
      WriteFile(file, text);
      const bool scenario = std::string(name).starts_with("scenarios");
      EXPECT_NO_THROW(read += (scenario ? DigestScenario(file) : DigestStandFile(file)) ? 1 : 0)
          << name << " round " << round;
    }
    WriteFile(file, valid);
  }
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace gyrobench::testing
