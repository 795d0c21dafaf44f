// The parts of LoadStandConfig and Load...Map that read a table already opened. Apart, so that a
// test can ask the table afterwards which keys are known (docs/configuration.md is checked against
// them).
#pragma once

#include "config/stand_config.h"

namespace gyrobench::config {

class TomlTable;

DriveMap ReadDriveMap(const TomlTable& root);
EncoderMap ReadEncoderMap(const TomlTable& root);
GyroUnitMap ReadGyroUnitMap(const TomlTable& root);
RelayMap ReadRelayMap(const TomlTable& root);
StandConfig ReadStandConfig(const TomlTable& root, const std::filesystem::path& file);

}  // namespace gyrobench::config
