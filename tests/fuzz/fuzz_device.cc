// libFuzzer target: the bytes are calls of the drivers and what their devices reply.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/device_laws.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gyrobench::testing::TalkToDevices({reinterpret_cast<const char*>(data), size});
  return 0;
}
