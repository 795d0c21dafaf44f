// Runs a procedure on a bench, dry or for real.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "procedures/engine/bench.h"
#include "procedures/engine/procedure.h"
#include "procedures/engine/sandbox.h"

namespace gyrobench::procedures {

struct RunHooks {
  // Before each command: the script's line and the command's name, "bench.turn".
  std::function<void(int line, const std::string& command)> on_command;
  SandboxLimits limits;
  std::int64_t max_commands = 1'000'000;
};

// How a run that came to its end went. A run that did not is an exception.
enum class RunOutcome { kPassed, kFailedLimits };

struct RunResult {
  RunOutcome outcome = RunOutcome::kPassed;
  std::vector<LimitCheck> checks;  // of bench.limit, in order
  std::int64_t commands = 0;
  std::int64_t instructions = 0;  // counted in steps of 200
};

// Checks the parameters, then executes the script's run(p) to its end, one command after the other,
// with a SafePoint before each.
//
// An exception out of the bench, a wrong field or a tripped limit of the sandbox ends the run at
// once: the script is not resumed, so its pcall cannot catch it and nothing moves after it. Throws
//   ParameterError            before the script is started;
//   ScriptError               the script failed: "scale.lua:41: ...", and bench.fail;
//   any other Error           out of the bench, of its own type, with the script's place set and
//                             "scale.lua:41: " put before;
//   Aborted                   out of the bench, and where the limits say that it is cancelled;
//   what is no Error          out of the bench, as it came.
RunResult RunProcedure(const Procedure& procedure, const Parameters& parameters, Bench& bench,
                       const RunHooks& hooks = {});

}  // namespace gyrobench::procedures
