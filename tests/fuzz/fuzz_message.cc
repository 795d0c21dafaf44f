// libFuzzer target: the bytes are the number of a type of messages, and a message of it.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/request_laws.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  gyrobench::testing::ShowAnything(data[0], {reinterpret_cast<const char*>(data + 1), size - 1});
  return 0;
}
