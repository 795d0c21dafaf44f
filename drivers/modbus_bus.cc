#include "drivers/modbus_bus.h"

#include <fmt/format.h>
#include <modbus/modbus.h>
#include <sys/file.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "drivers/modbus_line.h"

namespace gyrobench::drivers {

enum class ModbusFunction {
  kReadCoils = 1,
  kReadHolding = 3,
  kReadInput = 4,
  kWriteCoil = 5,
  kWriteRegister = 6,
  kWriteRegisters = 16
};

namespace {

using Transport = config::BusConfig::Transport;

// How long a line must be silent to be clean: beyond the 16 ms for which USB adapters hold bytes
// back.
constexpr Utime kQuiet_us = 20'000;
// A device that talks without end is left to fail the next request.
constexpr int kMostDrains = 10;
constexpr Utime kBusyPause_us = 10'000;

const char* FunctionName(ModbusFunction function) {
  switch (function) {
    case ModbusFunction::kReadCoils:
      return "read coils (function 01)";
    case ModbusFunction::kWriteCoil:
      return "write coil (function 05)";
    case ModbusFunction::kReadHolding:
      return "read holding registers (function 03)";
    case ModbusFunction::kReadInput:
      return "read input registers (function 04)";
    case ModbusFunction::kWriteRegister:
      return "write register (function 06)";
    case ModbusFunction::kWriteRegisters:
      return "write registers (function 16)";
  }
  return "?";
}

config::BusConfig Checked(const config::BusConfig& config) {
  if (config.transport == Transport::kRtu && !IsSettableBaud(config.baud)) {
    throw ConfigError(fmt::format(
        "bus {}: baud = {}: libmodbus cannot set this rate (it would use 9600 without a "
        "word); use 9600, 19200, 38400, 57600, 115200, 230400, 460800, 500000 or 1000000",
        config.name, config.baud));
  }
  return config;
}

modbus_t* NewContext(const config::BusConfig& config) {
  if (config.transport == Transport::kTcp) {
    return modbus_new_tcp_pi(config.host.c_str(), std::to_string(config.port).c_str());
  }
  return modbus_new_rtu(config.device.c_str(), config.baud, config.parity, 8, config.stop_bits);
}

void SetDeadline(modbus_t* context, Utime deadline_us) {
  modbus_set_response_timeout(context,
                              static_cast<std::uint32_t>(deadline_us / kMicrosecondsPerSecond),
                              static_cast<std::uint32_t>(deadline_us % kMicrosecondsPerSecond));
}

}  // namespace

struct ModbusBus::Line {
  modbus_t* context = nullptr;
  bool connected = false;
  ~Line() {
    if (context == nullptr) return;
    if (connected) modbus_close(context);
    modbus_free(context);
  }
};

struct ModbusBus::Request {
  const ModbusUnit& unit;
  ModbusFunction function;
  std::uint16_t address;
  std::uint16_t count;         // registers or coils
  std::uint16_t* read;         // where a reply's registers go
  const std::uint16_t* write;  // registers to be written; a coil by 0 or 1
  const char* what;
  Repeat repeat = Repeat::kAllowed;
  std::uint8_t* coils = nullptr;  // where a reply's coils go

  bool Reads() const { return read != nullptr || coils != nullptr; }
  // Bytes of the RTU frames.
  int RequestBytes() const {
    return function == ModbusFunction::kWriteRegisters ? 9 + 2 * count : 8;
  }
  int ReplyBytes() const {
    if (coils != nullptr) return 5 + (count + 7) / 8;
    return read != nullptr ? 5 + 2 * count : 8;
  }

  int Call(modbus_t* context) const {
    switch (function) {
      case ModbusFunction::kReadCoils:
        return modbus_read_bits(context, address, count, coils);
      case ModbusFunction::kWriteCoil:
        return modbus_write_bit(context, address, *write);
      case ModbusFunction::kReadHolding:
        return modbus_read_registers(context, address, count, read);
      case ModbusFunction::kReadInput:
        return modbus_read_input_registers(context, address, count, read);
      case ModbusFunction::kWriteRegister:
        return modbus_write_register(context, address, *write);
      case ModbusFunction::kWriteRegisters:
        return modbus_write_registers(context, address, count, write);
    }
    return -1;
  }
};

struct ModbusBus::Failure {
  int error = 0;  // errno of libmodbus; 0 = no failure
  bool late = false;
  bool connecting = false;
  bool again = true;  // worth another try
  Utime deadline_us = 0;
  Utime took_us = 0;
};

ModbusBus::ModbusBus(const config::BusConfig& config, Clock& clock, Clock::Participant& participant,
                     std::function<bool()> hurries)
    : config_(Checked(config)),
      response_timeout_us_(FromSeconds(config.response_timeout_s)),
      description_(DescribeBus(config)),
      clock_(clock),
      participant_(participant),
      hurries_(std::move(hurries)),
      line_(std::make_unique<Line>()),
      recorder_(clock.Now()) {}

ModbusBus::~ModbusBus() = default;

Timing ModbusBus::ReadHolding(const ModbusUnit& unit, std::uint16_t address,
                              std::span<std::uint16_t> values, const char* what) {
  return Transact({unit, ModbusFunction::kReadHolding, address,
                   static_cast<std::uint16_t>(values.size()), values.data(), nullptr, what});
}

Timing ModbusBus::ReadInput(const ModbusUnit& unit, std::uint16_t address,
                            std::span<std::uint16_t> values, const char* what) {
  return Transact({unit, ModbusFunction::kReadInput, address,
                   static_cast<std::uint16_t>(values.size()), values.data(), nullptr, what});
}

Timing ModbusBus::ReadCoils(const ModbusUnit& unit, std::uint16_t address,
                            std::span<std::uint8_t> values, const char* what) {
  return Transact({unit, ModbusFunction::kReadCoils, address,
                   static_cast<std::uint16_t>(values.size()), nullptr, nullptr, what,
                   Repeat::kAllowed, values.data()});
}

Timing ModbusBus::WriteCoil(const ModbusUnit& unit, std::uint16_t address, bool value,
                            const char* what) {
  const std::uint16_t on = value ? 1 : 0;
  return Transact({unit, ModbusFunction::kWriteCoil, address, 1, nullptr, &on, what});
}

Timing ModbusBus::WriteRegister(const ModbusUnit& unit, std::uint16_t address, std::uint16_t value,
                                const char* what) {
  return Transact({unit, ModbusFunction::kWriteRegister, address, 1, nullptr, &value, what});
}

void ModbusBus::WriteVerified(const ModbusUnit& unit, std::uint16_t address, std::uint16_t value,
                              const char* what) {
  WriteRegister(unit, address, value, what);
  std::array<std::uint16_t, 1> back = {};
  ReadHolding(unit, address, back, what);
  if (back[0] == value) return;
  throw DeviceError(
      fmt::format(
          "{} ({}, unit {}): {}: register 0x{:04X} was written with {} (0x{:04X}) and reads "
          "back {} (0x{:04X}). Check the register map against the device's manual, and "
          "whether the register is locked.",
          unit.name, description_, unit.unit, what, address, value, value, back[0], back[0]),
      {.device = unit.name, .action = what, .address = address});
}

Timing ModbusBus::WriteRegisters(const ModbusUnit& unit, std::uint16_t address,
                                 std::span<const std::uint16_t> values, const char* what,
                                 Repeat repeat) {
  return Transact({unit, ModbusFunction::kWriteRegisters, address,
                   static_cast<std::uint16_t>(values.size()), nullptr, values.data(), what,
                   repeat});
}

Timing ModbusBus::Transact(const Request& request) {
  CheckUnit(request.unit);
  const Utime begin = clock_.Now();
  LineRecorder::Transaction outcome;
  const int most_tries = request.repeat == Repeat::kNever ? 1 : 1 + std::max(0, config_.retries);
  for (int tries = 1;; ++tries) {
    Timing timing;
    timing.tries = tries;
    const Failure failure = Try(request, timing);
    outcome.tries = tries;
    if (failure.error == 0) {
      outcome.latency_us = timing.utime_reply - timing.utime_request;
      Record(request, begin, outcome);
      return timing;
    }
    Count(failure, outcome);
    if (failure.again && tries < most_tries && !hurries()) {
      continue;
    }
    outcome.given_up = true;
    Record(request, begin, outcome);
    const std::string message = Message(request, failure, tries);
    const DeviceFailure fields = FieldsOf(request, failure);
    if (IsException(failure.error)) throw RefusedByDevice(message, fields);
    if (failure.connecting) throw LineClosed(message, fields);
    throw NoAnswer(message, fields);
  }
}

void ModbusBus::Count(const Failure& failure, LineRecorder::Transaction& outcome) {
  const bool gateways_silence = failure.error == EMBXGPATH || failure.error == EMBXGTAR;
  if (gateways_silence || (failure.error == ETIMEDOUT && !failure.connecting)) {
    ++outcome.silent;
  } else if (IsException(failure.error)) {
    ++outcome.refused;
  } else if (failure.connecting || IsLinkLost(failure.error)) {
    ++outcome.line_lost;
  } else {
    ++outcome.unreadable;
  }
}

void ModbusBus::Record(const Request& request, Utime begin, LineRecorder::Transaction outcome) {
  const Utime now = clock_.Now();
  outcome.busy_us = now - begin;
  recorder_.Add(request.unit.name, request.unit.unit, now, outcome);
}

BusStatistics ModbusBus::statistics() const {
  BusStatistics sum;
  for (const UnitFigures& unit : Figures().all) {
    sum.transactions += unit.transactions;
    sum.retries += unit.retries;
    sum.failures += unit.given_up;
  }
  sum.connections = connections_;
  return sum;
}

LineFigures ModbusBus::Figures() const {
  LineFigures figures = recorder_.Figures(clock_.Now());
  figures.bus = config_.name;
  figures.description = description_;
  return figures;
}

// libmodbus would refuse the number and go on with that of the request before. Unit 0 is everybody.
void ModbusBus::CheckUnit(const ModbusUnit& unit) const {
  const bool tcp = config_.transport == Transport::kTcp;
  if (unit.unit >= (tcp ? 0 : config::kFirstUnit) && unit.unit <= config::kLastUnit) return;
  if (tcp && unit.unit == MODBUS_TCP_SLAVE) return;
  throw ConfigError(fmt::format("{} ({}): unit = {}: expected {} to {}{}", unit.name, description_,
                                unit.unit, config::kFirstUnit, config::kLastUnit,
                                tcp ? ", 0 or 255" : ""));
}

ModbusBus::Failure ModbusBus::Try(const Request& request, Timing& timing) {
  Failure failure;
  if (!Connect(failure)) return failure;
  WaitForSilence();
  modbus_t* context = line_->context;
  const Utime request_wire_us = WireTime(config_, request.RequestBytes());
  failure.deadline_us =
      response_timeout_us_ + request_wire_us + WireTime(config_, request.ReplyBytes());
  modbus_set_slave(context, request.unit.unit);
  SetDeadline(context, clock_.RealTimeout(failure.deadline_us));
  modbus_flush(context);

  timing.utime_request = clock_.Now();
  const int registers = request.Call(context);
  failure.error = registers == request.count ? 0 : errno;
  timing.utime_reply = clock_.Now();
  failure.took_us = timing.utime_reply - timing.utime_request;
  failure.late = failure.took_us > failure.deadline_us && failure.error != ETIMEDOUT;
  if (failure.late) failure.error = ETIMEDOUT;
  if (failure.error != 0) {
    AfterFailure(failure, timing.utime_request + failure.deadline_us);
    failure.again = !IsException(failure.error) || IsPassingException(failure.error);
    return failure;
  }
  timing.utime_latched = config_.transport == Transport::kTcp
                             ? timing.utime_request + failure.took_us / 2
                             : timing.utime_request + request_wire_us + FrameGap(config_);
  return failure;
}

bool ModbusBus::Connect(Failure& failure) {
  if (line_->connected) return true;
  WaitUntil(connect_not_before_);
  failure.connecting = true;
  if (line_->context == nullptr) {
    line_->context = NewContext(config_);
    if (line_->context == nullptr) {
      failure = {.error = errno, .connecting = true, .again = false};
      return false;
    }
    modbus_set_error_recovery(line_->context, MODBUS_ERROR_RECOVERY_NONE);
    modbus_set_byte_timeout(line_->context, 0, 0);
  }
  SetDeadline(line_->context, clock_.RealTimeout(response_timeout_us_));
  if (modbus_connect(line_->context) != 0) {
    // What was never there will not come by trying; what was there may be back in a moment.
    failure.error = errno != 0 ? errno : ENOTCONN;
    failure.again = was_connected_;
    connect_not_before_ = clock_.Now() + response_timeout_us_;
    return false;
  }
  // However late the line appears, and by whatever name: it is this one that is locked.
  if (config_.transport == Transport::kRtu &&
      flock(modbus_get_socket(line_->context), LOCK_EX | LOCK_NB) != 0) {
    failure = {.error = errno, .connecting = true, .again = false};
    modbus_close(line_->context);
    connect_not_before_ = clock_.Now() + response_timeout_us_;
    return false;
  }
  failure.connecting = false;
  line_->connected = true;
  was_connected_ = true;
  suspect_ = false;
  ++connections_;
  return true;
}

void ModbusBus::AfterFailure(const Failure& failure, Utime utime_deadline) {
  if (IsException(failure.error)) {
    if (IsPassingException(failure.error)) Wait(kBusyPause_us);
    return;
  }
  const bool silent = failure.error == ETIMEDOUT && !failure.late;
  if (silent) WaitUntil(utime_deadline);
  if (IsLinkLost(failure.error)) {
    Close();
    connect_not_before_ = clock_.Now() + response_timeout_us_;
    return;
  }
  InvalidateReply();
  // The reply that did not come may come yet; it gets as long again.
  if (silent) suspect_until_ = clock_.Now() + std::max(kQuiet_us, response_timeout_us_);
}

void ModbusBus::InvalidateReply() {
  if (config_.transport == Transport::kTcp) {
    Close();
    return;
  }
  suspect_ = true;
  suspect_until_ = clock_.Now() + std::max(kQuiet_us, FrameGap(config_));
}

void ModbusBus::WaitForSilence() {
  for (int drains = 0; suspect_ && drains < kMostDrains; ++drains) {
    WaitUntil(suspect_until_);
    int waiting = 0;
    suspect_ = ioctl(modbus_get_socket(line_->context), FIONREAD, &waiting) == 0 && waiting > 0;
    modbus_flush(line_->context);
    suspect_until_ = clock_.Now() + std::max(kQuiet_us, FrameGap(config_));
  }
  suspect_ = false;
}

void ModbusBus::Wait(Utime duration_us) { WaitUntil(clock_.Now() + duration_us); }

void ModbusBus::WaitUntil(Utime utime) {
  bool notified = false;
  while (clock_.Now() < utime) notified = participant_.WaitUntil(utime) || notified;
  if (notified) participant_.Notify();
}

void ModbusBus::Close() {
  if (!line_->connected) return;
  modbus_close(line_->context);
  line_->connected = false;
}

DeviceFailure ModbusBus::FieldsOf(const Request& request, const Failure& failure) {
  return {.device = request.unit.name,
          .action = request.what,
          .code_kind = CodeKindOf(failure.error),
          .code = CodeOf(failure.error),
          .address = request.address};
}

std::string ModbusBus::Message(const Request& request, const Failure& failure, int tries) const {
  const std::string where = fmt::format("{} ({}, unit {}): {}", request.unit.name, description_,
                                        request.unit.unit, request.what);
  const std::string advice = AdviceForFault(failure.error, config_);
  if (failure.connecting) {
    return fmt::format("{}: cannot open {}: {} ({} {}). {}", where, description_,
                       DescribeFault(failure.error), tries, tries == 1 ? "try" : "tries", advice);
  }
  const double deadline_ms = static_cast<double>(failure.deadline_us) * 1e-3;
  std::string came = DescribeFault(failure.error);
  if (failure.late) {
    came = fmt::format("a reply after {:.1f} ms, too late to be used",
                       static_cast<double>(failure.took_us) * 1e-3);
  } else if (failure.error == ETIMEDOUT) {
    came = "no complete reply";
  }
  const bool coils = request.function == ModbusFunction::kReadCoils ||
                     request.function == ModbusFunction::kWriteCoil;
  return fmt::format("{}: {} at 0x{:04X}: expected {} {} within {:.1f} ms, got {} ({} {}). {}",
                     where, FunctionName(request.function), request.address,
                     request.Reads() ? "a reply of" : "an echo for",
                     fmt::format("{} {}{}", request.count, coils ? "coil" : "register",
                                 request.count == 1 ? "" : "s"),
                     deadline_ms, came, tries, tries == 1 ? "try" : "tries", advice);
}

}  // namespace gyrobench::drivers
