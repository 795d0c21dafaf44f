#include "tests/fuzz/allocation_meter.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace {

// operator new knows no object that could hold them.
std::atomic<std::size_t> held_bytes{0};
std::atomic<std::size_t> peak_bytes{0};
std::atomic<std::size_t> start_bytes{0};

}  // namespace

void* operator new(std::size_t size) {
  void* place = std::malloc(std::max<std::size_t>(size, 1));
  if (place == nullptr) throw std::bad_alloc();
  const std::size_t held = held_bytes += malloc_usable_size(place);
  if (held > peak_bytes) peak_bytes = held;
  return place;
}

// That of the library does not call the one above.
void* operator new(std::size_t size, const std::nothrow_t& /*nothrow*/) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

void operator delete(void* place) noexcept {
  held_bytes -= malloc_usable_size(place);
  std::free(place);
}

void operator delete(void* place, std::size_t /*size*/) noexcept { operator delete(place); }

void operator delete(void* place, const std::nothrow_t& /*nothrow*/) noexcept {
  operator delete(place);
}

namespace gyrobench::testing {

void StartMeter() {
  start_bytes = held_bytes.load();
  peak_bytes = held_bytes.load();
}

std::size_t PeakBytes() { return peak_bytes - start_bytes; }

}  // namespace gyrobench::testing
