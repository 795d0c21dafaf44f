// What the bases of effects share.
#pragma once

#include <memory>
#include <numbers>
#include <utility>

#include "calibration/trace/effect.h"

namespace gyrobench::calibration {

inline constexpr double kTwoPi = 2.0 * std::numbers::pi;
inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;

class ChannelBasis : public Basis {
 public:
  explicit ChannelBasis(BasisContext context) : context_(std::move(context)) {}

 protected:
  const BasisContext& context() const { return context_; }
  double rate(const TrackPoint& point) const { return point.rate_deg_s[context_.channel]; }
  double table_rad(const TrackPoint& point) const {
    return point.table_deg[context_.table_axis] * kRadPerDeg;
  }

 private:
  BasisContext context_;
};

using BasisMaker = std::unique_ptr<Basis> (*)(const BasisContext& context);

template <typename T>
std::unique_ptr<Basis> Make(const BasisContext& context) {
  return std::make_unique<T>(context);
}

}  // namespace gyrobench::calibration
