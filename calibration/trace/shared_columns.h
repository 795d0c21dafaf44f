// The further columns that several measurements have in common: what may be traced to them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/signal/collector.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct SharedColumns {
  // In every measurement, known for most of its time, and not the same all along. Sorted.
  std::vector<std::string> names;
  // Effects of columns that are there and stay (nearly) the same.
  std::vector<Unidentifiable> unidentifiable;
};

// What is not shared is said in `remarks`.
SharedColumns FindSharedColumns(std::span<const Recording* const> recordings,
                                std::vector<std::string>* remarks);

}  // namespace gyrobench::calibration
