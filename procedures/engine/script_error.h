// What can go wrong with a script.
#pragma once

#include <string>

#include "base/error.h"

namespace gyrobench::procedures {

// A script that is wrong, failed, or used more than it may. what() begins with file and line once
// the place is known.
class ScriptError : public Error {
 public:
  using Error::Error;  // the place follows
  // `line` 0: none is known.
  ScriptError(const std::string& file, int line, const std::string& message) : Error(message) {
    SetPlace({file, line});
  }
};

}  // namespace gyrobench::procedures
