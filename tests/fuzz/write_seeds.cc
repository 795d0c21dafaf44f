// fuzz_write_seeds FOLDER: valid inputs for the fuzzing targets, one folder each.
#include <fmt/format.h>

#include <cstdio>

#include "tests/fuzz/calibration_laws.h"
#include "tests/fuzz/request_laws.h"
#include "tests/fuzz/samples.h"
#include "tests/recording/gzip.h"
#include "tests/recording/record_builder.h"
#include "tests/recording/sinks.h"

namespace fs = std::filesystem;
using gyrobench::TemporaryFolder;
using gyrobench::recording::Gzip;
using gyrobench::recording::ReadFile;
using gyrobench::recording::WriteFile;

namespace {

void WriteTalk(const fs::path& out) {
  int number = 0;
  for (const auto& request : gyrobench::testing::SampleRequests()) {
    WriteFile(out / "request" / std::to_string(number++), request.text);
  }
  for (std::size_t kind = 0; kind < gyrobench::testing::KindsOfMessages(); ++kind) {
    WriteFile(out / "message" / std::to_string(kind),
              static_cast<char>(kind) + gyrobench::testing::SampleMessage(kind));
  }
  for (const auto& [name, bytes] : gyrobench::testing::SampleScripts()) {
    WriteFile(out / "script" / name, bytes);
  }
  // Open and read all, undamaged but for the last word.
  WriteFile(out / "device/opened",
            std::string("\0\0\0\0\0\0\0\4\0\0\0\0\0\0\10\0\0\1\5\0\1\5\200\3\377", 25));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "expected: fuzz_write_seeds FOLDER\n");
    return 2;
  }
  const fs::path out = argv[1];
  for (const char* target : {"calibration", "config", "record", "run_json", "table", "request",
                             "message", "script", "device"}) {
    fs::create_directories(out / target);
  }
  for (const auto& [name, bytes] : gyrobench::testing::SampleTables()) {
    WriteFile(out / "table" / name, bytes);
    WriteFile(out / "table" / (name + ".gz"), Gzip(bytes));
  }
  WriteTalk(out);
  const TemporaryFolder scratch;
  const auto record = gyrobench::testing::MakeSampleRecord(scratch / "run");
  WriteFile(out / "record/with_run_json", std::string(1, '\0') + record.log);
  WriteFile(out / "record/alone", std::string(1, '\1') + record.log);
  // Nothing that a fuzzer changes comes beyond a checksum.
  const std::string earlier = gyrobench::recording::WithoutChecksums(scratch / "run/events.lcmlog");
  WriteFile(out / "record/earlier_with_run_json", std::string(1, '\0') + earlier);
  WriteFile(out / "record/earlier_alone", std::string(1, '\1') + earlier);
  WriteFile(out / "run_json/valid", record.run_json);
  WriteFile(out / "calibration/valid", gyrobench::testing::SampleCalibration());
  const fs::path config = fs::path(GYROBENCH_SOURCE_DIR) / "config";
  for (const char* name : {"stand.toml", "one-axis.toml", "virtual.toml", "scenarios/typical.toml",
                           "scenarios/full-sequence.toml"}) {
    WriteFile(out / "config" / fs::path(name).filename(), ReadFile(config / name));
  }
  return 0;
}
