// Counts calls of operator new, for tests of code that must not allocate.
#pragma once

#include <cstdint>

namespace gyrobench {

std::int64_t AllocationsOfThisThread();

}  // namespace gyrobench
