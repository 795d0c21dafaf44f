// Factors of composed and empirical terms: named functions of the state.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "calibration/state/sensor_state.h"

namespace gyrobench::calibration {

// A named quantity of the state: w (rate about the channel's axis), abs_w, w_x, w_y, w_z, g_x, g_y,
// g_z, T, dT_dt, or a covariate's column name.
class Factor {
 public:
  // nullopt when the name is neither one of the above nor in `covariates`.
  static std::optional<Factor> Make(const std::string& name, std::size_t channel,
                                    const std::vector<std::string>& covariates);
  double At(const SensorState& point) const;  // NaN when it is not known there
  const std::string& name() const { return name_; }
  const std::string& unit() const { return unit_; }

 private:
  enum class Kind { kRate, kAbsRate, kGravity, kTemperature, kTemperatureRate, kCovariate };
  Kind kind_ = Kind::kRate;
  std::size_t index_ = 0;
  std::string name_, unit_;
};

}  // namespace gyrobench::calibration
