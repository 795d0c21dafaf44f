#include "drivers/identify.h"

#include <fmt/format.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <span>
#include <utility>

#include "base/error.h"
#include "config/words.h"
#include "drivers/modbus_line.h"

namespace gyrobench::drivers {
namespace {

using CodeKind = DeviceFailure::CodeKind;

// Of a gateway: it has no way to the device, and its device did not answer.
constexpr int kNoPath = 10, kNoDeviceBehind = 11;
// A disturbance spoils one reply, a wrong setting or a second device all of them.
constexpr int kTries = 3;
// A reply may be lost: of a device that is expected, or has answered before.
constexpr int kSilences = 2;

enum class End { kAnswered, kRefused, kSilent, kUnreadable };

// How one request ended, and what is said of it where it failed.
struct Outcome {
  End end = End::kAnswered;
  std::string words = {};
};

Outcome OutcomeOf(const DeviceFailure& failure) {
  const bool exception = failure.code_kind == CodeKind::kModbusException;
  if (exception && (failure.code == kNoPath || failure.code == kNoDeviceBehind))
    return {End::kSilent, "the gateway's device did not answer"};
  if (failure.code_kind == CodeKind::kSystemError) return {End::kSilent, "no reply"};
  const int error = failure.code + MODBUS_ENOBASE;
  // A sound frame: the code is the vendor's own.
  if (exception || error == EMBBADEXC) return {End::kRefused, DescribeFault(error)};
  return {End::kUnreadable, DescribeFault(error)};
}

// Asks again after a reply that cannot be read, and after silence `silences` times in all. What
// ends in silence was silent: so is a server that closes the connection of a unit that it does not
// know.
template <typename Ask>
Outcome AskUntilReadable(int silences, Ask&& ask) {
  Outcome outcome;
  for (int tries = 0; tries < kTries; ++tries) {
    try {
      ask();
      return {};
    } catch (const LineClosed&) {
      throw;
    } catch (const DeviceError& error) {
      outcome = OutcomeOf(error.failure());
    }
    if (outcome.end == End::kRefused) break;
    if (outcome.end == End::kSilent && --silences <= 0) break;
  }
  return outcome;
}

ModbusUnit UnitOf(int unit) { return {fmt::format("unit {}", unit), unit}; }

// Registers of a unit, where it has them.
class Registers {
 public:
  Registers(ModbusBus& bus, int unit, int silences)
      : bus_(bus), unit_(UnitOf(unit)), silences_(silences) {}

  Outcome Read(int function, int address, std::span<std::uint16_t> words) {
    return AskUntilReadable(silences_, [&] {
      const auto at = static_cast<std::uint16_t>(address);
      if (function == 4) {
        bus_.ReadInput(unit_, at, words, "what it is");
      } else {
        bus_.ReadHolding(unit_, at, words, "what it is");
      }
    });
  }
  bool Has(int function, int address, std::span<std::uint16_t> words) {
    return Read(function, address, words).end == End::kAnswered;
  }
  std::optional<std::uint16_t> Holding(int address) {
    std::array<std::uint16_t, 1> word = {};
    return Has(3, address, word) ? std::optional(word[0]) : std::nullopt;
  }
  bool HasCoils(int address, std::span<std::uint8_t> coils) {
    const auto at = static_cast<std::uint16_t>(address);
    return AskUntilReadable(silences_, [&] {
             bus_.ReadCoils(unit_, at, coils, "what it is");
           }).end == End::kAnswered;
  }

 private:
  ModbusBus& bus_;
  ModbusUnit unit_;
  int silences_;
};

// docs/gyro-unit.md, identity.
std::optional<UnitIdentity> As(Registers& registers, const config::GyroUnitMap& map,
                               const ExpectedUnit* expected) {
  std::array<std::uint16_t, 7> words = {};
  if (!registers.Has(4, map.identity_address, words) || words[0] != map.magic) return std::nullopt;
  const std::uint32_t serial = config::FromWords(words[3], words[4]);
  UnitIdentity unit{UnitKind::kGyroUnit, map.model,
                    fmt::format("serial number {}, firmware {}.{}, protocol {}", serial,
                                words[2] >> 8, words[2] & 0xFF, words[1])};
  if (words[1] != map.protocol_version)
    unit.wrong.push_back(
        fmt::format("Its protocol is {}, and {} is expected: load the firmware of this version of "
                    "gyrobench.",
                    words[1], map.protocol_version));
  if (words[6] != map.who_am_i)
    unit.wrong.push_back(
        fmt::format("WHO_AM_I of its sensor is 0x{:02X}, and 0x{:02X} is expected: check the "
                    "sensor's supply and its I2C lines, or the map.",
                    words[6], map.who_am_i));
  if (expected != nullptr && expected->serial_number.value_or(serial) != serial)
    unit.wrong.push_back(
        fmt::format("Its serial number is {}, and {} is expected: connect that unit, or correct "
                    "gyro.serial_number.",
                    serial, *expected->serial_number));
  return unit;
}

std::optional<UnitIdentity> As(Registers& registers, const config::DriveMap& map,
                               const ExpectedUnit*) {
  std::array<std::uint16_t, 2> position = {};
  const auto pulses = registers.Holding(map.pulses_per_turn_address);
  const auto status = pulses ? registers.Holding(map.status_address) : std::nullopt;
  if (!status || !registers.Has(3, map.position_address, position)) return std::nullopt;
  const auto at =
      static_cast<std::int32_t>(config::FromWords(position[0], position[1], map.word_order));
  UnitIdentity unit{
      UnitKind::kDrive, map.model,
      fmt::format("{} pulses a turn, at pulse {}, status 0x{:04X}", *pulses, at, *status)};
  if (*pulses != map.pulses_per_turn) {
    unit.wrong.push_back(
        fmt::format("It is set to {} pulses a turn, and {} are expected: set the drive (gyrobench "
                    "devices --write), or correct pulses_per_turn of its table in the stand file "
                    "or of its map.",
                    *pulses, map.pulses_per_turn));
    unit.settings.push_back({"pulses per turn", map.pulses_per_turn_address, *pulses,
                             static_cast<std::uint16_t>(map.pulses_per_turn)});
  }
  if (config::IsBitSet(*status, map.fault_bit))
    unit.wrong.push_back("It reports a fault: remove its cause and clear the alarm.");
  return unit;
}

std::optional<UnitIdentity> As(Registers& registers, const config::EncoderMap& map,
                               const ExpectedUnit*) {
  std::array<std::uint16_t, 2> words = {};
  const std::span<std::uint16_t> wanted(words.data(), map.words == 2 ? 2 : 1);
  if (!registers.Has(map.function, map.address, wanted)) return std::nullopt;
  const std::uint32_t value =
      map.words == 1 ? words[0] : config::FromWords(words[0], words[1], map.word_order);
  UnitIdentity unit{UnitKind::kEncoder, map.model,
                    fmt::format("value {}, {:.2f} deg", value,
                                static_cast<double>(value) * 360.0 / map.counts_per_turn)};
  if (value >= map.range_counts)
    unit.wrong.push_back(
        fmt::format("Its value is {}, and less than {} is expected: check words, word order and "
                    "range of the map.",
                    value, map.range_counts));
  return unit;
}

std::optional<UnitIdentity> As(Registers& registers, const config::RelayMap& map,
                               const ExpectedUnit*) {
  std::vector<std::uint8_t> coils(static_cast<std::size_t>(map.channels));
  if (!registers.HasCoils(map.first_coil, coils)) return std::nullopt;
  const auto on = std::ranges::count_if(coils, [](std::uint8_t coil) { return coil != 0; });
  return UnitIdentity{UnitKind::kRelayUnit, map.model,
                      fmt::format("{} of {} channels on", on, coils.size())};
}

std::optional<UnitIdentity> AsExpected(Registers& registers, const ExpectedUnit& expected) {
  return std::visit([&](const auto& map) { return As(registers, map, &expected); }, expected.map);
}

}  // namespace

const char* NameOf(UnitKind kind) {
  switch (kind) {
    case UnitKind::kSilent:
      return "silent";
    case UnitKind::kUnreadable:
      return "unreadable replies";
    case UnitKind::kUnknown:
      return "unknown device";
    case UnitKind::kDrive:
      return "drive";
    case UnitKind::kEncoder:
      return "encoder";
    case UnitKind::kGyroUnit:
      return "gyro unit";
    case UnitKind::kRelayUnit:
      return "relay unit";
  }
  return "?";
}

std::vector<ExpectedUnit> ExpectedOn(const config::StandConfig& stand, const std::string& bus) {
  std::vector<ExpectedUnit> expected;
  const auto add = [&](const std::string& on, ExpectedUnit unit) {
    if (on == bus) expected.push_back(std::move(unit));
  };
  for (const config::AxisConfig& axis : stand.axes) {
    add(axis.drive.bus,
        {axis.drive.unit, "axis." + axis.name + " drive", UnitKind::kDrive, axis.drive.map});
    add(axis.encoder.bus, {axis.encoder.unit, "axis." + axis.name + " encoder", UnitKind::kEncoder,
                           axis.encoder.map});
  }
  add(stand.gyro.bus,
      {stand.gyro.unit, "gyro", UnitKind::kGyroUnit, stand.gyro.map, stand.gyro.serial_number});
  if (stand.relays)
    add(stand.relays->bus, {stand.relays->unit, "relays", UnitKind::kRelayUnit, stand.relays->map});
  return expected;
}

UnitIdentity Hail(ModbusBus& bus, int unit) {
  std::array<std::uint16_t, 1> word = {};
  const Outcome outcome = Registers(bus, unit, 1).Read(3, 0, word);
  switch (outcome.end) {
    case End::kSilent:
      return {};
    case End::kUnreadable:
      return {UnitKind::kUnreadable, "", outcome.words};
    case End::kRefused:
      return {UnitKind::kUnknown, "", "register 0x0000: " + outcome.words};
    case End::kAnswered:
      break;
  }
  return {UnitKind::kUnknown, "", fmt::format("register 0x0000 holds {}", word[0])};
}

UnitIdentity Identify(ModbusBus& bus, int unit, const ExpectedUnit* expected,
                      const std::vector<ExpectedUnit>& known) {
  Registers registers(bus, unit, kSilences);
  if (expected != nullptr) {
    if (auto found = AsExpected(registers, *expected)) return *found;
  }
  UnitIdentity answer = Hail(bus, unit);
  if (answer.kind != UnitKind::kUnknown) return answer;
  // Of several that fit the first whose settings are as its map says. Where a device is expected
  // another one of the stand is likely; else an encoder's few registers say nothing.
  std::optional<UnitIdentity> fits;
  for (const ExpectedUnit& one : known) {
    const bool tells = one.kind == UnitKind::kDrive || one.kind == UnitKind::kGyroUnit;
    if (!tells && expected == nullptr) continue;
    if (!tells && fits) continue;
    auto found = std::visit([&](const auto& map) { return As(registers, map, nullptr); }, one.map);
    if (!found) continue;
    if (!fits || found->wrong.size() < fits->wrong.size()) fits = std::move(found);
    if (fits->wrong.empty()) break;
  }
  if (fits) return *fits;
  for (const UnitKind kind : {UnitKind::kEncoder, UnitKind::kRelayUnit}) {
    const bool fits_one = std::ranges::any_of(known, [&](const ExpectedUnit& one) {
      return one.kind == kind && AsExpected(registers, one);
    });
    if (!fits_one) continue;
    answer.may_be.push_back(kind);
    answer.says +=
        fmt::format("; it may be {} {}", kind == UnitKind::kEncoder ? "an" : "a", NameOf(kind));
  }
  return answer;
}

}  // namespace gyrobench::drivers
