// What is said of a key of a scenario file.
#pragma once

#include <string_view>

#include "config/scenario.h"

namespace gyrobench::config {

struct KeyInfo {
  std::string_view unit;
  double min, max;
  std::string_view help;
};

// A rate error or a scale error beyond this is a wrong number, not an imperfection.
inline constexpr double kMostRel = 0.2;

}  // namespace gyrobench::config
