#include "procedures/engine/bench.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"

namespace gyrobench::procedures {

WiringReport Bench::FindWiring() {
  throw LimitError("only a procedure with `commissions = true` finds out how a stand is wired");
}

std::string Bench::WriteStandFile() {
  throw LimitError("nothing was found out about the wiring that could be written");
}

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
