// The exceptions of gyrobench. A broken bench or a wrong input is an exception; a part that misses
// its limits is a value (results carry PASS or FAIL), never an exception.
#pragma once

#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace gyrobench {

// A line of a procedure's script. Line 0: none is known.
struct ScriptPlace {
  std::string file;  // name without folder
  int line = 0;
};

// Root of all exceptions of gyrobench. what() is a whole message for a person: what went wrong,
// where (file and line, device and register), what was expected and found, and what to do about it.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;

  // The place is put before the message: "scale.lua:41: ...". An error that has one keeps it, since
  // the first to know the place is the nearest to the cause.
  void SetPlace(const ScriptPlace& place) {
    if (place_) return;
    place_ = place;
    placed_ = place.file + ":" + (place.line > 0 ? std::to_string(place.line) + ":" : "") + " " +
              std::runtime_error::what();
  }
  // Where a script asked for what went wrong; nullopt where no script did.
  const std::optional<ScriptPlace>& place() const { return place_; }
  const char* what() const noexcept override {
    return place_ ? placed_.c_str() : std::runtime_error::what();
  }

 private:
  std::optional<ScriptPlace> place_;
  std::string placed_;
};

// A configuration, register map or scenario file that cannot be used.
class ConfigError : public Error {
 public:
  using Error::Error;
};

// What is known of a device's failure beside its words. Empty fields are not known.
struct DeviceFailure {
  // Whose the code is. kBadReply: libmodbus's number of what is wrong with the frame.
  enum class CodeKind { kNone, kModbusException, kSystemError, kBadReply, kAlarm };

  std::string device{};  // "axis.inner drive", "axis.inner encoder", "gyro", "relays"
  std::string action{};  // what was read, written or done: "status", "move"
  CodeKind code_kind = CodeKind::kNone;
  int code = 0;                  // Modbus exception code, errno, or the drive's alarm
  std::optional<int> address{};  // of the first register or coil, as on the wire
};

// A device that is missing, silent, of the wrong identity, or that answers what it must not.
class DeviceError : public Error {
 public:
  using Error::Error;
  DeviceError(const std::string& message, DeviceFailure failure)
      : Error(message), failure_(std::move(failure)) {}
  const DeviceFailure& failure() const { return failure_; }

 private:
  DeviceFailure failure_;
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

// "record: the disk is full", "axis.inner drive: no answer": a source and what happened there,
// without the source where the words begin with it.
inline std::string WithSource(const std::string& source, const std::string& message) {
  const bool named = message.starts_with(source) &&
                     (message.size() == source.size() ||
                      std::string_view(" :.,").find(message[source.size()]) != std::string::npos);
  return named ? message : source + ": " + message;
}

}  // namespace gyrobench
