// libFuzzer target: the bytes are a request to the daemon: a line METHOD PATH, then the body.
#include <cstddef>
#include <cstdint>

#include "tests/fuzz/request_laws.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static gyrobench::daemon::FakeBench bench;
  gyrobench::testing::AskAnything(bench, {reinterpret_cast<const char*>(data), size});
  return 0;
}
