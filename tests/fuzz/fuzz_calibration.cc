// libFuzzer target: the bytes are a calibration file, which is applied.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/calibration_laws.h"
#include "tests/recording/sinks.h"

using gyrobench::TemporaryFolder;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryFolder folder;
  gyrobench::recording::WriteFile(folder / "calibration.json",
                                  {reinterpret_cast<const char*>(data), size});
  gyrobench::testing::DigestCalibration(folder / "calibration.json");
  return 0;
}
