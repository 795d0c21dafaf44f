#include "stand/motion.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::stand {
namespace {

void AddStop(Plan& plan, double t_s, double x, double v, double down) {
  if (v == 0.0) {
    plan.Add({.t0_s = t_s, .x0 = std::round(x)});
    return;
  }
  const double way = v * std::abs(v) / (2.0 * down);
  // To the whole pulse beyond, braking a little less.
  double end = v > 0 ? std::ceil(x + way) : std::floor(x + way);
  if (end == x) end += v > 0 ? 1.0 : -1.0;
  const double brake = -v * v / (2.0 * (end - x));
  plan.Add({.t0_s = t_s, .x0 = x, .v0 = v, .a = brake});
  plan.Add({.t0_s = t_s - v / brake, .x0 = end});
}

void AddTrapezoid(Plan& plan, double t_s, double x, double target, const Ramp& ramp) {
  const double way = std::abs(target - x);
  if (way > 0) {
    const double sign = target > x ? 1.0 : -1.0;
    const double peak =
        std::min(ramp.speed, std::sqrt(2.0 * way * ramp.up * ramp.down / (ramp.up + ramp.down)));
    const double way_up = peak * peak / (2.0 * ramp.up);
    const double way_down = peak * peak / (2.0 * ramp.down);
    const double way_cruise = std::max(0.0, way - way_up - way_down);
    plan.Add({.t0_s = t_s, .x0 = x, .a = sign * ramp.up});
    t_s += peak / ramp.up;
    plan.Add({.t0_s = t_s, .x0 = x + sign * way_up, .v0 = sign * peak});
    t_s += way_cruise / peak;
    plan.Add(
        {.t0_s = t_s, .x0 = target - sign * way_down, .v0 = sign * peak, .a = -sign * ramp.down});
    t_s += peak / ramp.down;
  }
  plan.Add({.t0_s = t_s, .x0 = target});
}

}  // namespace

Ramp RampOf(const MoveCommand& command, double pulses_per_turn, double clock_rel) {
  const double clock = 1.0 + clock_rel;
  const double pulses_per_rpm_s = pulses_per_turn / 60.0;
  const auto acceleration = [&](double ramp_ms) {
    return 1000.0 * pulses_per_rpm_s / (ramp_ms * 1e-3) * clock * clock;
  };
  return {.speed = command.rpm * pulses_per_rpm_s * clock,
          .up = acceleration(command.ramp_up_ms),
          .down = acceleration(command.ramp_down_ms)};
}

Plan PlanStop(double t_s, double x, double v, double down) {
  Plan plan;
  AddStop(plan, t_s, x, v, down);
  return plan;
}

Plan PlanMove(double t_s, double x, double v, std::int64_t target, const Ramp& ramp) {
  Plan plan;
  if (v == 0.0) {
    AddTrapezoid(plan, t_s, std::round(x), static_cast<double>(target), ramp);
    return plan;
  }
  Plan stop;
  AddStop(stop, t_s, x, v, ramp.down);
  plan.Add(stop.segments().front());
  AddTrapezoid(plan, stop.back().t0_s, stop.back().x0, static_cast<double>(target), ramp);
  return plan;
}

}  // namespace gyrobench::stand
