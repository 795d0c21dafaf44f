// Noise figures as an operator reads them: in JSON of a trace or an analysis, under the same names.
#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace gyrobench::cli {

struct NoiseLine {
  std::string name, value, unit;  // value "-" where there is none
  std::string note;               // why it was not seen, empty where it was
};

// Angle random walk, bias random walk and reference noise. What the data could not have shown
// (report/noise_limits.h) is "not seen": the limit is that of the best analysis, and no bound.
std::array<NoiseLine, 3> NoiseLines(const nlohmann::json& noise, double duration_s);

}  // namespace gyrobench::cli
