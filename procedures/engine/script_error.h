// What can go wrong with a script.
#pragma once

#include <string>

#include "base/error.h"

namespace gyrobench::procedures {

// A script that is wrong, failed, or used more than it may. what() begins with file and line.
class ScriptError : public Error {
 public:
  // `line` 0: none is known.
  ScriptError(const std::string& file, int line, const std::string& message)
      : Error(file + ":" + (line > 0 ? std::to_string(line) + ":" : "") + " " + message),
        file_(file),
        line_(line) {}
  const std::string& file() const { return file_; }
  int line() const { return line_; }

 private:
  std::string file_;
  int line_;
};

}  // namespace gyrobench::procedures
