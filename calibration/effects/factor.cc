#include "calibration/effects/factor.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {

std::optional<Factor> Factor::Make(const std::string& name, std::size_t channel,
                                   const std::vector<std::string>& covariates) {
  Factor factor;
  factor.name_ = name;
  const auto is = [&](Kind kind, std::size_t index, const char* unit) {
    factor.kind_ = kind;
    factor.index_ = index;
    factor.unit_ = unit;
    return factor;
  };
  if (name == "w") return is(Kind::kRate, channel, "deg/s");
  if (name == "abs_w") return is(Kind::kAbsRate, channel, "deg/s");
  if (name == "T") return is(Kind::kTemperature, 0, "degC");
  if (name == "dT_dt") return is(Kind::kTemperatureRate, 0, "degC/s");
  const bool has_axis = name.size() == 3 && name[1] == '_' && name[2] >= 'x' && name[2] <= 'z';
  if (has_axis && (name[0] == 'w' || name[0] == 'g')) {
    const auto axis = static_cast<std::size_t>(name[2] - 'x');
    return name[0] == 'w' ? is(Kind::kRate, axis, "deg/s") : is(Kind::kGravity, axis, "g");
  }
  const auto found = std::find(covariates.begin(), covariates.end(), name);
  if (found == covariates.end()) return std::nullopt;
  return is(Kind::kCovariate, static_cast<std::size_t>(found - covariates.begin()), "");
}

double Factor::At(const SensorState& point) const {
  switch (kind_) {
    case Kind::kRate:
      return point.rate_deg_s[index_];
    case Kind::kAbsRate:
      return std::fabs(point.rate_deg_s[index_]);
    case Kind::kGravity:
      return point.gravity_g[index_];
    case Kind::kTemperature:
      return point.temperature_degC;
    case Kind::kTemperatureRate:
      return point.temperature_rate_degC_s;
    case Kind::kCovariate:
      return point.covariates == nullptr ? kMissing : point.covariates[index_];
  }
  return kMissing;
}

}  // namespace gyrobench::calibration
