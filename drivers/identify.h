// What a unit on a line is, told by reading its registers alone: nothing is written, nothing moves.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/stand_config.h"
#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {

enum class UnitKind {
  kSilent,
  kUnreadable,  // something answers, and no reply is a sound frame
  kUnknown,     // it answers, and no known register map fits
  kDrive,
  kEncoder,
  kGyroUnit,
  kRelayUnit
};

// "drive", "encoder", "gyro unit", "relay unit", "device of no known map" ...
const char* NameOf(UnitKind kind);

struct UnitIdentity {
  UnitKind kind = UnitKind::kSilent;
  std::string model = {};  // of the register map that fits
  // In words: what its registers hold; of kUnreadable what is wrong with the replies.
  std::string says = {};
};

// The register maps that units are held against, one of each model.
struct KnownMaps {
  std::vector<config::DriveMap> drives;
  std::vector<config::EncoderMap> encoders;
  std::optional<config::GyroUnitMap> gyro_unit;
  std::optional<config::RelayMap> relays;
};

KnownMaps MapsOf(const config::StandConfig& stand);

// Asks whether a unit is there. A gateway's word that its device was silent counts as silence, any
// other exception as an answer. The identity is kSilent, kUnreadable, or kUnknown for one that
// answers. Throws NoAnswer where the line itself cannot be opened.
UnitIdentity Hail(ModbusBus& bus, int unit);

// What a unit that answers is: that of whose map it answers every register that the driver reads.
// The gyro unit is told by its magic number, a drive before an encoder, since an encoder's few
// registers may be a part of a drive's. Throws as Hail does.
UnitIdentity Identify(ModbusBus& bus, int unit, const KnownMaps& maps);

}  // namespace gyrobench::drivers
