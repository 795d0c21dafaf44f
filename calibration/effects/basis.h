// What the bases of effects share.
#pragma once

#include <cmath>
#include <cstddef>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include "base/geometry.h"
#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

inline constexpr double kTwoPi = 2.0 * std::numbers::pi;

class ChannelBasis : public Basis {
 public:
  explicit ChannelBasis(BasisContext context) : context_(std::move(context)) {}

 protected:
  const BasisContext& context() const { return context_; }
  double rate(const SensorState& point) const { return point.rate_deg_s[context_.channel]; }
  // Of a power-on, from 0.
  double start_side(std::size_t power_on) const {
    const std::vector<double>& sides = context_.start_sides;
    return power_on < sides.size() ? sides[power_on] : 0.0;
  }
  double other_delays_s(double t_s) const { return TotalDelay_s(context_.other_delays, t_s); }

 private:
  BasisContext context_;
};

// Size of the mean of m waves of size 1, evenly by x in their phase: about their middle
//   sin(m x / 2) / (m sin(x / 2))
inline double MeanOfWave(std::size_t waves, double x) {
  const auto m = static_cast<double>(waves);
  const double one = m * std::sin(0.5 * x);
  return std::fabs(one) > 1e-9 ? std::sin(0.5 * m * x) / one : 1.0;
}

using BasisMaker = std::unique_ptr<Basis> (*)(const BasisContext& context);

template <typename T>
std::unique_ptr<Basis> Make(const BasisContext& context) {
  return std::make_unique<T>(context);
}

}  // namespace gyrobench::calibration
