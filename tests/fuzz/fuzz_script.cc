// libFuzzer target: the bytes are a script.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/request_laws.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gyrobench::testing::PlanAnything({reinterpret_cast<const char*>(data), size});
  return 0;
}
