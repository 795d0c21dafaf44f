// Counts calls of operator new, for tests of code that must not allocate.
#pragma once

#include <cstdint>

namespace gyrobench {

std::int64_t AllocationsOfThisThread();
// What they asked for in all.
std::int64_t BytesAllocatedByThisThread();

}  // namespace gyrobench
