// The formats, one source file each.
#pragma once

#include <array>

#include "export/exporter.h"

namespace gyrobench::exporting {

// c_header.cc: w = A (xi / s0 - b(T) - effects), C99 and C++.
Exported WriteCHeader(const calibration::Calibration& calibration, const Origin& origin);
// px4.cc: TC_G0_*, the offset in rad/s as a cubic of the temperature.
Exported WritePx4(const calibration::Calibration& calibration, const Origin& origin);
// ardupilot.cc: INS_TCAL1_GYR*, INS_GYROFFS_*, INS_GYR1_CALTEMP.
Exported WriteArduPilot(const calibration::Calibration& calibration, const Origin& origin);
// kalibr.cc: gyroscope_noise_density, gyroscope_random_walk.
Exported WriteKalibr(const calibration::Calibration& calibration, const Origin& origin);
// json_format.cc: everything that `gyrobench apply` uses.
Exported WriteJson(const calibration::Calibration& calibration, const Origin& origin);

// In the order in which help names them.
inline constexpr auto kFormats = std::to_array<Format>({
    {"c", "C header", WriteCHeader},
    {"px4", "PX4 parameters", WritePx4},
    {"ardupilot", "ArduPilot parameters", WriteArduPilot},
    {"kalibr", "Kalibr IMU file", WriteKalibr},
    {"json", "JSON", WriteJson},
});

}  // namespace gyrobench::exporting
