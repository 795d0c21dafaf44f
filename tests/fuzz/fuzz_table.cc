// libFuzzer target: the bytes are a measurement table, plain or compressed.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/laws.h"
#include "tests/recording/sinks.h"

using gyrobench::TemporaryFolder;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  const std::filesystem::path table = folder / "table.csv";
  gyrobench::recording::WriteFile(table, {reinterpret_cast<const char*>(data), size});
  if (gyrobench::testing::Digest(table)) {
    gyrobench::testing::DigestExported(table, folder.path());
  }
  return 0;
}
