#include "drivers/identify.h"

#include <fmt/format.h>
#include <modbus/modbus.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <span>

#include "base/error.h"
#include "drivers/modbus_line.h"
#include "drivers/words.h"

namespace gyrobench::drivers {
namespace {

using CodeKind = DeviceFailure::CodeKind;

// Of a gateway: it has no way to the device, and its device did not answer.
constexpr int kNoPath = 10, kNoDeviceBehind = 11;
// A disturbance spoils one reply, a wrong setting or a second device all of them.
constexpr int kUnreadableReplies = 3;

bool IsGatewaysSilence(const DeviceFailure& failure) {
  return failure.code_kind == CodeKind::kModbusException &&
         (failure.code == kNoPath || failure.code == kNoDeviceBehind);
}

ModbusUnit UnitOf(int unit) { return {fmt::format("unit {}", unit), unit}; }

template <typename Map>
void AddModel(std::vector<Map>& maps, const Map& map) {
  const auto same = [&map](const Map& other) { return other.model == map.model; };
  if (std::none_of(maps.begin(), maps.end(), same)) maps.push_back(map);
}

// Registers of a unit, where it has them.
class Registers {
 public:
  Registers(ModbusBus& bus, int unit) : bus_(bus), unit_(UnitOf(unit)) {}

  bool Read(int function, int address, std::span<std::uint16_t> words) {
    return Answers([&] {
      const auto at = static_cast<std::uint16_t>(address);
      if (function == 4) {
        bus_.ReadInput(unit_, at, words, "what it is");
      } else {
        bus_.ReadHolding(unit_, at, words, "what it is");
      }
    });
  }
  std::optional<std::uint16_t> Holding(int address) {
    std::array<std::uint16_t, 1> word = {};
    return Read(3, address, word) ? std::optional(word[0]) : std::nullopt;
  }
  bool ReadCoils(int address, std::span<std::uint8_t> coils) {
    return Answers(
        [&] { bus_.ReadCoils(unit_, static_cast<std::uint16_t>(address), coils, "what it is"); });
  }

 private:
  // A unit that is there and silent to a request does not know its function.
  template <typename Ask>
  static bool Answers(Ask&& ask) {
    try {
      ask();
      return true;
    } catch (const DeviceError&) {
      return false;
    }
  }

  ModbusBus& bus_;
  ModbusUnit unit_;
};

std::optional<UnitIdentity> AsGyroUnit(Registers& registers, const config::GyroUnitMap& map) {
  std::array<std::uint16_t, 6> words = {};
  if (!registers.Read(4, map.identity_address, words) || words[0] != map.magic) return std::nullopt;
  return UnitIdentity{
      UnitKind::kGyroUnit, map.model,
      fmt::format("serial number {}, firmware {}.{}, protocol {}{}", FromWords(words[3], words[4]),
                  words[2] >> 8, words[2] & 0xFF, words[1],
                  words[1] == map.protocol_version
                      ? ""
                      : fmt::format(" (expected {}: load the firmware of this "
                                    "version of gyrobench)",
                                    map.protocol_version))};
}

std::optional<UnitIdentity> AsDrive(Registers& registers, const config::DriveMap& map) {
  std::array<std::uint16_t, 8> path = {};
  std::array<std::uint16_t, 2> position = {};
  const auto pulses = registers.Holding(map.pulses_per_turn_address);
  const auto status = pulses ? registers.Holding(map.status_address) : std::nullopt;
  if (!status || !registers.Read(3, map.position_address, position) ||
      !registers.Read(3, map.path_address, path)) {
    return std::nullopt;
  }
  const auto at = static_cast<std::int32_t>(FromWords(position[0], position[1], map.word_order));
  std::string says =
      fmt::format("{} pulses a turn, at pulse {}, status 0x{:04X}", *pulses, at, *status);
  if (*pulses != map.pulses_per_turn) says += fmt::format("; expected {}", map.pulses_per_turn);
  if (IsBitSet(*status, map.fault_bit)) says += "; reports a fault";
  return UnitIdentity{UnitKind::kDrive, map.model, says};
}

std::optional<UnitIdentity> AsEncoder(Registers& registers, const config::EncoderMap& map) {
  std::array<std::uint16_t, 2> words = {};
  const std::span<std::uint16_t> wanted(words.data(), map.words == 2 ? 2 : 1);
  if (!registers.Read(map.function, map.address, wanted)) return std::nullopt;
  const std::uint32_t value =
      map.words == 1 ? words[0] : FromWords(words[0], words[1], map.word_order);
  if (value >= map.range_counts) {
    return UnitIdentity{UnitKind::kEncoder, map.model,
                        fmt::format("{} counts, expected below {}: check words and word order",
                                    value, map.range_counts)};
  }
  return UnitIdentity{
      UnitKind::kEncoder, map.model,
      fmt::format("{} counts, {:.2f} deg", value, value * 360.0 / map.counts_per_turn)};
}

std::optional<UnitIdentity> AsRelayUnit(Registers& registers, const config::RelayMap& map) {
  std::vector<std::uint8_t> coils(static_cast<std::size_t>(map.channels));
  if (!registers.ReadCoils(map.first_coil, coils)) return std::nullopt;
  const auto on =
      std::count_if(coils.begin(), coils.end(), [](std::uint8_t coil) { return coil != 0; });
  return UnitIdentity{UnitKind::kRelayUnit, map.model,
                      fmt::format("{} of {} channels on", on, coils.size())};
}

}  // namespace

const char* NameOf(UnitKind kind) {
  switch (kind) {
    case UnitKind::kSilent:
      return "silent";
    case UnitKind::kUnreadable:
      return "unreadable replies";
    case UnitKind::kUnknown:
      return "device of no known map";
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

KnownMaps MapsOf(const config::StandConfig& stand) {
  KnownMaps maps;
  for (const config::AxisConfig& axis : stand.axes) {
    AddModel(maps.drives, axis.drive.map);
    AddModel(maps.encoders, axis.encoder.map);
  }
  maps.gyro_unit = stand.gyro.map;
  if (stand.relays) maps.relays = stand.relays->map;
  return maps;
}

UnitIdentity Hail(ModbusBus& bus, int unit) {
  std::array<std::uint16_t, 1> word = {};
  UnitIdentity identity;
  for (int replies = 0; replies < kUnreadableReplies; ++replies) {
    try {
      bus.ReadHolding(UnitOf(unit), 0, word, "whether it answers");
      return {UnitKind::kUnknown, "", fmt::format("register 0x0000 holds {}", word[0])};
    } catch (const RefusedByDevice& refusal) {
      if (IsGatewaysSilence(refusal.failure())) return {};
      return {UnitKind::kUnknown, "",
              fmt::format("register 0x0000: {}",
                          DescribeFault(refusal.failure().code + MODBUS_ENOBASE))};
    } catch (const NoAnswer& failed) {
      const DeviceFailure& failure = failed.failure();
      if (failure.code_kind == CodeKind::kSystemError && failure.code == ETIMEDOUT) return identity;
      if (IsGatewaysSilence(failure)) return {};
      if (failure.code_kind != CodeKind::kBadReply) throw;
      identity = {UnitKind::kUnreadable, "", DescribeFault(failure.code + MODBUS_ENOBASE)};
    }
  }
  return identity;
}

UnitIdentity Identify(ModbusBus& bus, int unit, const KnownMaps& maps) {
  const UnitIdentity answer = Hail(bus, unit);
  if (answer.kind != UnitKind::kUnknown) return answer;
  Registers registers(bus, unit);
  if (maps.gyro_unit) {
    if (const auto found = AsGyroUnit(registers, *maps.gyro_unit)) return *found;
  }
  for (const config::DriveMap& map : maps.drives) {
    if (const auto found = AsDrive(registers, map)) return *found;
  }
  for (const config::EncoderMap& map : maps.encoders) {
    if (const auto found = AsEncoder(registers, map)) return *found;
  }
  if (maps.relays) {
    if (const auto found = AsRelayUnit(registers, *maps.relays)) return *found;
  }
  return answer;
}

}  // namespace gyrobench::drivers
