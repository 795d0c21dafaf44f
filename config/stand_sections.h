// Sections of the stand file that stand by themselves. Errors as those of LoadStandConfig.
#pragma once

#include "config/stand_config.h"
#include "config/toml_reader.h"

namespace gyrobench::config {

// [lcm]: where results go, and the begin of all channel names. What LCM itself would complain of
// once a second is refused with file and key.
LcmConfig ReadLcm(const TomlTable& table);

// [virtual]: the simulation in place of the stand. The scenario must be there.
VirtualConfig ReadVirtual(const TomlTable& table);

}  // namespace gyrobench::config
