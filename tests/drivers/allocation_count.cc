#include "tests/drivers/allocation_count.h"

#include <cstdlib>
#include <new>

namespace {
thread_local std::int64_t allocations = 0;
thread_local std::int64_t bytes = 0;
}  // namespace

std::int64_t gyrobench::AllocationsOfThisThread() { return allocations; }
std::int64_t gyrobench::BytesAllocatedByThisThread() { return bytes; }

// Replaces the program's own, in a file of its own so that the compiler does not inline half of a
// pair.
void* operator new(std::size_t size) {
  ++allocations;
  bytes += static_cast<std::int64_t>(size);
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
