// fuzz_write_seeds FOLDER: valid inputs for the fuzzing targets, one folder each.
#include <fmt/format.h>

#include <cstdio>

#include "tests/fuzz/calibration_laws.h"
#include "tests/fuzz/samples.h"
#include "tests/recording/gzip.h"
#include "tests/recording/sinks.h"

namespace fs = std::filesystem;
using gyrobench::TemporaryFolder;
using gyrobench::recording::Gzip;
using gyrobench::recording::ReadFile;
using gyrobench::recording::WriteFile;

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "expected: fuzz_write_seeds FOLDER\n");
    return 2;
  }
  const fs::path out = argv[1];
  for (const char* target : {"calibration", "config", "record", "run_json", "table"}) {
    fs::create_directories(out / target);
  }
  for (const auto& [name, bytes] : gyrobench::testing::SampleTables()) {
    WriteFile(out / "table" / name, bytes);
    WriteFile(out / "table" / (name + ".gz"), Gzip(bytes));
  }
  const TemporaryFolder scratch;
  const auto record = gyrobench::testing::MakeSampleRecord(scratch / "run");
  WriteFile(out / "record/with_run_json", std::string(1, '\0') + record.log);
  WriteFile(out / "record/alone", std::string(1, '\1') + record.log);
  WriteFile(out / "run_json/valid", record.run_json);
  WriteFile(out / "calibration/valid", gyrobench::testing::SampleCalibration());
  const fs::path config = fs::path(GYROBENCH_SOURCE_DIR) / "config";
  for (const char* name : {"stand.toml", "one-axis.toml", "virtual.toml", "scenarios/typical.toml",
                           "scenarios/full-sequence.toml"}) {
    WriteFile(out / "config" / fs::path(name).filename(), ReadFile(config / name));
  }
  return 0;
}
