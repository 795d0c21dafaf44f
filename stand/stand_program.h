// The virtual stand as a process of its own, in real time.
#pragma once

#include <functional>
#include <memory>

#include "config/stand_config.h"
#include "stand/devices/device.h"
#include "stand/virtual_stand.h"

namespace gyrobench::stand {

// Another gyro unit in place of the stand's own: VirtualStand::MakeGyroUnit, of a stand file.
using MakeGyroUnitOf =
    std::function<std::unique_ptr<Device>(const config::StandConfig&, Physics&, Utime start)>;

// What main of gyrobench-stand does: returns the exit status, once SIGTERM or SIGINT came.
int RunStandProgram(int argc, const char* const* argv, const MakeGyroUnitOf& make_gyro_unit = {});

}  // namespace gyrobench::stand
