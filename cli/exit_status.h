// How gyrobench ends.
#pragma once

#include "base/error.h"

namespace gyrobench::cli {

enum ExitStatus : int {
  kDone = 0,
  kFailed = 1,
  kUsage = 2,
  kFailedLimits = 3,  // the run was completed and the part missed its limits
};

// The command line asks for what cannot be; ends with kUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

}  // namespace gyrobench::cli
