// What a stepper drive makes of a command: trapezoids of the motor's position.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

namespace gyrobench::stand {

// A stretch of constant acceleration, from `t0_s` until the next one begins.
//   x(t) = x0 + v0 (t - t0) + a (t - t0)^2 / 2      [pulses]
struct Segment {
  double t0_s = 0.0;
  double x0 = 0.0;
  double v0 = 0.0;  // pulses/s
  double a = 0.0;   // pulses/s^2
  // State of the plays at t0 (see mechanics.h) [deg of table].
  double table0_deg = 0.0;
  double coupled0_deg = 0.0;

  double Position(double t_s) const {
    const double dt = t_s - t0_s;
    return x0 + (v0 + 0.5 * a * dt) * dt;
  }
  double Rate(double t_s) const { return v0 + a * (t_s - t0_s); }
  bool Rests() const { return v0 == 0.0 && a == 0.0; }
};

// A move as the drive's registers say it.
struct MoveCommand {
  std::int64_t target = 0;  // pulses, absolute
  double rpm = 0.0;         // of the shaft, > 0
  double ramp_up_ms = 0.0;  // per 1000 rpm, > 0
  double ramp_down_ms = 0.0;
};

// Up to: stop the motion before (1), accelerate, cruise, brake, rest.
class Plan {
 public:
  void Add(const Segment& segment) { segments_[count_++] = segment; }
  std::span<const Segment> segments() const { return {segments_.data(), count_}; }
  const Segment& back() const { return segments_[count_ - 1]; }

 private:
  std::array<Segment, 6> segments_;
  std::size_t count_ = 0;
};

// Speeds in pulses/s and accelerations in pulses/s^2 of a command, with the drive's own clock.
struct Ramp {
  double speed = 0.0, up = 0.0, down = 0.0;
};
Ramp RampOf(const MoveCommand& command, double pulses_per_turn, double clock_rel);

// Brakes from (x, v) at `t_s` with `down`, to rest on a whole pulse.
Plan PlanStop(double t_s, double x, double v, double down);
// Goes to `target`, from (x, v) at `t_s`; a motion still running is braked first.
Plan PlanMove(double t_s, double x, double v, std::int64_t target, const Ramp& ramp);

// The play operator, the follower of a loose link: where the follower is when the leader has gone,
// without turning back, to `x`: it stays until the leader is half the play ahead, then follows.
// `before` is where it was.
constexpr double Follow(double before, double x, double half_width) {
  return std::clamp(before, x - half_width, x + half_width);
}

}  // namespace gyrobench::stand
