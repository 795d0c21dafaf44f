// What a unit on a line is, told by reading its registers alone: nothing is written, nothing moves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "config/stand_config.h"
#include "drivers/drive_setting.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

enum class UnitKind {
  kSilent,
  kUnreadable,  // something answers, and no reply is a sound frame
  kUnknown,     // it answers, and its registers do not say as what
  kDrive,
  kEncoder,
  kGyroUnit,
  kRelayUnit
};

// "drive", "encoder", "gyro unit", "relay unit", "unknown device" ...
const char* NameOf(UnitKind kind);

struct UnitIdentity {
  UnitKind kind = UnitKind::kSilent;
  std::string model = {};  // of the register map that fits
  // In words: what its registers hold; of kUnreadable what is wrong with the replies.
  std::string says = {};
  // Why the daemon would refuse it: each a sentence with what was expected and found, and what to
  // do.
  std::vector<std::string> wrong = {};
  // Of these what can be set there (drive_setting.h).
  std::vector<WrongSetting> settings = {};
  // Of kUnknown: what has such registers.
  std::vector<UnitKind> may_be = {};
};

// A device of the stand file.
struct ExpectedUnit {
  int unit = 0;
  std::string device = {};  // "axis.inner drive"
  UnitKind kind = UnitKind::kUnknown;
  std::variant<config::DriveMap, config::EncoderMap, config::GyroUnitMap, config::RelayMap> map;
  std::optional<std::uint32_t> serial_number = {};  // of a gyro unit, where the file says it
};

std::vector<ExpectedUnit> ExpectedOn(const config::StandConfig& stand, const std::string& bus);

// Whether a unit is there, by its holding register 0x0000: an exception is an answer as well, but
// that of a gateway, whose device was silent. kSilent, kUnreadable, or kUnknown for one that
// answers. A unit that ignores requests of this function seems silent. Throws NoAnswer where the
// line itself is lost.
UnitIdentity Hail(ModbusBus& bus, int unit);

// What the unit is by the map of the device that is expected there: it answers all that the driver
// reads by it at first. Where it does not, and for all others, it is hailed, and told by the
// `known` maps. Where nothing is expected those of drives and gyro units alone say what it is: a
// register of so many parts fits that of an encoder. Throws as Hail does.
UnitIdentity Identify(ModbusBus& bus, int unit, const ExpectedUnit* expected,
                      const std::vector<ExpectedUnit>& known);

}  // namespace gyrobench::drivers
