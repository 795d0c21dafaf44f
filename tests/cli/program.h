// The built program, run to its end without a stand file.
#pragma once

#include <string>
#include <vector>

#include "tests/cli/child_process.h"

namespace gyrobench::cli {

inline Finished Gyrobench(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), GYROBENCH_PROGRAM);
  return RunToEnd(arguments, {"GYROBENCH_CONFIG="});
}

}  // namespace gyrobench::cli
