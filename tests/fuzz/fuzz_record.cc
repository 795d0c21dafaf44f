// libFuzzer target: the bytes are the event log of a record. The first one says whether there is a
// run.json beside it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/laws.h"
#include "tests/fuzz/samples.h"
#include "tests/recording/sinks.h"

using gyrobench::TemporaryFolder;
using gyrobench::recording::WriteFile;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  static const gyrobench::testing::SampleRecord sample =
      gyrobench::testing::MakeSampleRecord(folder / "run");
  if (size == 0) return 0;
  WriteFile(folder / "run/events.lcmlog", {reinterpret_cast<const char*>(data + 1), size - 1});
  std::filesystem::remove(folder / "run/run.json");
  if (data[0] % 2 == 0) WriteFile(folder / "run/run.json", sample.run_json);
  gyrobench::testing::Digest(folder / "run");
  return 0;
}
