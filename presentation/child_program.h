// Runs a program to its end: text in, text out, no shell between.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace gyrobench::presentation {

struct ProgramRun {
  bool started = false;    // false: there is no such program, or it may not be run
  bool timed_out = false;  // it was ended for it
  int exit_status = -1;    // 128 + signal where a signal ended it
  std::string out, err;
};

// Runs `command` (the program, looked for in PATH, and its arguments) with `input` as standard
// input, for `limit` at most. Throws Error only where the system gives no file or pipe to do it.
ProgramRun RunProgram(const std::vector<std::string>& command, const std::string& input,
                      std::chrono::milliseconds limit);

}  // namespace gyrobench::presentation
