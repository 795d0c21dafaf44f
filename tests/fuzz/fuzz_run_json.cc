// libFuzzer target: the bytes are the run.json of a record with a sound log.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/laws.h"
#include "tests/fuzz/samples.h"
#include "tests/recording/sinks.h"

using gyrobench::TemporaryFolder;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  static const gyrobench::testing::SampleRecord sample =
      gyrobench::testing::MakeSampleRecord(folder / "run");
  gyrobench::recording::WriteFile(folder / "run/run.json",
                                  {reinterpret_cast<const char*>(data), size});
  gyrobench::testing::Digest(folder / "run");
  return 0;
}
