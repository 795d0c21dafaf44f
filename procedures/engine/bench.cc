#include "procedures/engine/bench.h"

#include <fmt/format.h>

#include <cmath>

namespace gyrobench::procedures {

std::string Describe(const SwingCommand& command) {
  return fmt::format("{} ±{:g} deg at {:g} Hz", command.axis, command.amplitude_deg,
                     command.frequency_hz);
}

std::string Describe(const LimitCheck& check) {
  std::string range;
  if (std::isinf(check.min)) {
    range = fmt::format("at most {:.10g}", check.max);
  } else if (std::isinf(check.max)) {
    range = fmt::format("at least {:.10g}", check.min);
  } else {
    range = fmt::format("{:.10g} .. {:.10g}", check.min, check.max);
  }
  const std::string unit = check.unit.empty() ? "" : " " + check.unit;
  return fmt::format("{} = {:.6g}{}: {} ({}{})", check.name, check.value, unit,
                     check.passed ? "PASS" : "FAIL", range, unit);
}

}  // namespace gyrobench::procedures
