// The exceptions of gyrobench. A broken bench or a wrong input is an exception; a part that misses
// its limits is a value (results carry PASS or FAIL), never an exception.
#pragma once

#include <stdexcept>
#include <string>

namespace gyrobench {

// Root of all exceptions of gyrobench. what() is a whole message for a person: what went wrong,
// where (file and line, device and register), what was expected and found, and what to do about it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// A configuration, register map or scenario file that cannot be used.
class ConfigError : public Error {
 public:
  using Error::Error;
};

// A device that is missing, silent, of the wrong identity, or that answers what it must not.
class DeviceError : public Error {
 public:
  using Error::Error;
};

// A motion or parameter beyond a limit. Thrown before anything moves.
class LimitError : public Error {
 public:
  using Error::Error;
};

// Recorded data that cannot be read, or that cannot support the estimate asked for.
class DataError : public Error {
 public:
  using Error::Error;
};

}  // namespace gyrobench
