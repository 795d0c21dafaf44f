#include "drivers/modbus_line.h"

#include <fmt/format.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "config/bus_load.h"

namespace gyrobench::drivers {
namespace {

using Transport = config::BusConfig::Transport;

const char* ExceptionName(int code) {
  switch (code) {
    case 1:
      return "illegal function";
    case 2:
      return "illegal data address";
    case 3:
      return "illegal data value";
    case 4:
      return "device failure";
    case 5:
      return "acknowledge";
    case 6:
      return "device busy";
    case 7:
      return "negative acknowledge";
    case 8:
      return "memory parity error";
    case 10:
      return "gateway path unavailable";
    case 11:
      return "gateway's device did not answer";
    default:
      return "unknown code";
  }
}

std::string LineSettings(const config::BusConfig& bus) {
  return fmt::format("{} baud 8{}{}", bus.baud, bus.parity, bus.stop_bits);
}

std::string AdviceForSerialOpen(int error, const config::BusConfig& bus) {
  if (error == EACCES || error == EPERM) {
    return fmt::format("Check that this user may open {} (group dialout).", bus.device);
  }
  if (error == EWOULDBLOCK) {
    return fmt::format(
        "Find the other daemon with `fuser {}` and end it, or give bus {} a line of "
        "its own.",
        bus.device, bus.name);
  }
  return fmt::format(
      "Check that the serial adapter is plugged in and that `device` of bus {} names it.",
      bus.name);
}

}  // namespace

bool IsException(int error) { return error >= EMBXILFUN && error <= EMBXGTAR; }

bool IsPassingException(int error) { return error == EMBXSBUSY || error == EMBXGTAR; }

bool IsLinkLost(int error) { return error != ETIMEDOUT && error < MODBUS_ENOBASE; }

DeviceFailure::CodeKind CodeKindOf(int error) {
  if (IsException(error)) return DeviceFailure::CodeKind::kModbusException;
  return error < MODBUS_ENOBASE ? DeviceFailure::CodeKind::kSystemError
                                : DeviceFailure::CodeKind::kBadReply;
}

int CodeOf(int error) { return error < MODBUS_ENOBASE ? error : error - MODBUS_ENOBASE; }

std::string DescribeFault(int error) {
  if (IsException(error)) {
    const int code = error - MODBUS_ENOBASE;
    return fmt::format("exception {:02} ({})", code, ExceptionName(code));
  }
  switch (error) {
    case EMBBADCRC:
      return "a reply with a wrong checksum (CRC)";
    case EMBBADSLAVE:
      return "a reply of another unit";
    case EMBBADDATA:
      return "a reply of another function, length or transaction";
    case EMBBADEXC:
    case EMBUNKEXC:
      return "an exception reply with an unknown code";
    case EWOULDBLOCK:
      return "another process has locked it";
    default:
      return error >= MODBUS_ENOBASE ? modbus_strerror(error)
                                     : std::generic_category().message(error);
  }
}

std::string AdviceForFault(int error, const config::BusConfig& bus) {
  const bool tcp = bus.transport == Transport::kTcp;
  if (IsPassingException(error)) return "Check what the device is busy with and that it has power.";
  if (IsException(error)) {
    return "Check that the device is of the configured model, and its register map against its "
           "manual.";
  }
  if (error == ETIMEDOUT) {
    return tcp ? "Check the device's power, the network and the unit number."
               : fmt::format(
                     "Check the device's power, the cable, its unit number and that it is set to "
                     "{}.",
                     LineSettings(bus));
  }
  if (!IsLinkLost(error)) {
    return tcp ? "Check that nothing else uses this connection's unit and that the device is a "
                 "Modbus one."
               : fmt::format(
                     "Check that no two devices share a unit number, the line's termination, and "
                     "that "
                     "all devices are set to {}.",
                     LineSettings(bus));
  }
  if (!tcp) return AdviceForSerialOpen(error, bus);
  return fmt::format("Check that the Modbus server is running and reachable at {}:{}.", bus.host,
                     bus.port);
}

std::string DescribeBus(const config::BusConfig& bus) {
  if (bus.transport == Transport::kTcp) {
    return fmt::format("bus {} (Modbus TCP {}:{})", bus.name, bus.host, bus.port);
  }
  return fmt::format("bus {} ({}, {})", bus.name, bus.device, LineSettings(bus));
}

Utime WireTime(const config::BusConfig& bus, double bytes) {
  if (bus.transport == config::BusConfig::Transport::kTcp) return 0;
  const int bits = 1 + 8 + (bus.parity == 'N' ? 0 : 1) + bus.stop_bits;
  return FromSeconds(bytes * bits / bus.baud);
}

Utime FrameGap(const config::BusConfig& bus) { return WireTime(bus, 3.5); }

bool IsSettableBaud(int baud) {
  const std::vector<int>& bauds = config::SettableBauds();
  return std::find(bauds.begin(), bauds.end(), baud) != bauds.end();
}

}  // namespace gyrobench::drivers
