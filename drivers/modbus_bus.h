// One Modbus line, RTU or TCP: every transaction of every device on it goes through here.
//
// libmodbus is used with a discipline that its defaults lack:
//  * a deadline for the whole reply, not for each byte: response timeout plus the time of both
//    frames on the wire;
//  * what was left over on the line is thrown away before each request;
//  * a late or bad reply is never used. TCP: the connection is closed, since the next reply could
//    belong to the last request. RTU: the line must be silent before the next request;
//  * a bounded number of tries, then a DeviceError.
//  * a serial line is locked (flock) by who opens it, so that no other daemon uses it.
// A reply is checked for its unit (RTU; libmodbus does not show it on TCP, where the transaction
// number is checked instead), function, length and checksum.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "base/clock.h"
#include "base/error.h"
#include "config/stand_config.h"
#include "drivers/line_figures.h"

namespace gyrobench::drivers {

// When a transaction happened, host clock.
struct Timing {
  Utime utime_request = 0;  // request written
  // Device took the request. RTU: request, its time on the wire and the 3.5 characters of silence
  // that end it. TCP: the middle between request and reply.
  Utime utime_latched = 0;
  Utime utime_reply = 0;  // reply complete
  int tries = 1;          // of which the last succeeded
};

// A device on the line; `name` is for messages ("axis.inner drive").
struct ModbusUnit {
  std::string name;
  int unit = 1;
};

// No answer, or none that can be used: the device, or its line, may be well again in a moment.
class NoAnswer : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

// The line itself could not be opened: it is not known whether a device is there.
class LineClosed : public NoAnswer {
 public:
  using NoAnswer::NoAnswer;
};

// The device answered with a Modbus exception: it is there, and will not do what was asked.
class RefusedByDevice : public DeviceError {
 public:
  using DeviceError::DeviceError;
};

struct BusStatistics {
  std::int64_t transactions = 0;  // asked for, whatever their end
  std::int64_t retries = 0;       // tries beyond the first
  std::int64_t failures = 0;      // transactions that ended in a DeviceError
  std::int64_t connections = 0;   // successful opens of the line
};

// Whether a request may be sent again when its reply was lost. kNever: it is not known whether the
// device acted on it, and acting twice is not the same as once (a relative move).
enum class Repeat { kAllowed, kNever };

// Belongs to one thread, that of `participant`. Nothing is opened before the first transaction.
// Every transaction throws NoAnswer, or RefusedByDevice for an exception reply, that names device,
// bus, unit, function, address, what was expected and what came, and what to check, and has them as
// fields. `what` says in a word what is read or written; it is used in errors only. No transaction
// allocates unless it fails.
class ModbusBus {
 public:
  // Throws ConfigError for a rate that libmodbus cannot set. `hurries`: asked after a try that
  // failed; true: there is no other, since something urgent waits for the line.
  ModbusBus(const config::BusConfig& config, Clock& clock, Clock::Participant& participant,
            std::function<bool()> hurries = {});
  ~ModbusBus();
  ModbusBus(const ModbusBus&) = delete;
  ModbusBus& operator=(const ModbusBus&) = delete;

  // Functions 03 and 04; fills `values` (1 to 125 registers).
  Timing ReadHolding(const ModbusUnit& unit, std::uint16_t address, std::span<std::uint16_t> values,
                     const char* what);
  Timing ReadInput(const ModbusUnit& unit, std::uint16_t address, std::span<std::uint16_t> values,
                   const char* what);
  // Function 01; fills `values` (1 to 2000 coils) with 0 and 1.
  Timing ReadCoils(const ModbusUnit& unit, std::uint16_t address, std::span<std::uint8_t> values,
                   const char* what);
  // Function 05.
  Timing WriteCoil(const ModbusUnit& unit, std::uint16_t address, bool value, const char* what);
  // Function 06. The echo is not checked by libmodbus: for what matters use WriteVerified.
  Timing WriteRegister(const ModbusUnit& unit, std::uint16_t address, std::uint16_t value,
                       const char* what);
  // Function 06, then the register is read back and must hold the value.
  void WriteVerified(const ModbusUnit& unit, std::uint16_t address, std::uint16_t value,
                     const char* what);
  // Function 16 (1 to 123 registers).
  Timing WriteRegisters(const ModbusUnit& unit, std::uint16_t address,
                        std::span<const std::uint16_t> values, const char* what,
                        Repeat repeat = Repeat::kAllowed);

  // Something urgent waits for the line: what is asked again and again for something to settle is
  // given up.
  bool hurries() const { return hurries_ && hurries_(); }
  // Says that the last reply cannot have been the answer to the last request (a driver knows more
  // of the content than the protocol does): the line is cleaned before the next request.
  void InvalidateReply();
  // Waits for a time of the bench. A Notify of the participant does not cut it short and is kept.
  void Wait(Utime duration_us);
  // "bus A (/dev/ttyUSB0, 115200 baud 8N1)", for messages.
  const std::string& description() const { return description_; }
  BusStatistics statistics() const;
  // From any thread.
  LineFigures Figures() const;

 private:
  struct Line;
  struct Request;
  struct Failure;

  Timing Transact(const Request& request);
  Failure Try(const Request& request, Timing& timing);
  static void Count(const Failure& failure, LineRecorder::Transaction& outcome);
  void Record(const Request& request, Utime begin, LineRecorder::Transaction outcome);
  void CheckUnit(const ModbusUnit& unit) const;
  bool Connect(Failure& failure);
  void AfterFailure(const Failure& failure, Utime utime_deadline);
  void WaitForSilence();
  void WaitUntil(Utime utime);
  void Close();
  std::string Message(const Request& request, const Failure& failure, int tries) const;
  static DeviceFailure FieldsOf(const Request& request, const Failure& failure);

  const config::BusConfig config_;
  const Utime response_timeout_us_;
  const std::string description_;
  Clock& clock_;
  Clock::Participant& participant_;
  const std::function<bool()> hurries_;
  std::unique_ptr<Line> line_;
  bool was_connected_ = false;
  Utime connect_not_before_ = 0;
  // A reply that nobody waits for any more may still come until then, or is on the line already.
  bool suspect_ = false;
  Utime suspect_until_ = 0;
  std::int64_t connections_ = 0;
  LineRecorder recorder_;
};

}  // namespace gyrobench::drivers
