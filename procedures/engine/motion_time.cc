#include "procedures/engine/motion_time.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace gyrobench::procedures {
namespace {

constexpr double kMaxWait_s = 86400.0;

// `what` with its value must lie in (0, limit].
void CheckPositive(const AxisFacts& axis, const char* what, const char* unit, double value,
                   double limit) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw LimitError(fmt::format("axis.{}: {} {:.10g} {}: expected a number above 0", axis.name,
                                 what, value, unit));
  }
  if (value > limit) {
    throw LimitError(fmt::format("axis.{}: {:.10g} {} is beyond the {} limit {:.10g} {}", axis.name,
                                 value, unit, what, limit, unit));
  }
}

void CheckDuration(const char* field, double value, double max) {
  if (value >= 0.0 && value <= max) return;
  throw LimitError(fmt::format("{} = {:.10g} s: expected 0 .. {:.10g} s", field, value, max));
}

}  // namespace

double MoveDuration_s(double angle_deg, double rate_deg_s, double acceleration_deg_s2) {
  const double distance = std::abs(angle_deg);
  if (distance * acceleration_deg_s2 >= rate_deg_s * rate_deg_s) {
    return distance / rate_deg_s + rate_deg_s / acceleration_deg_s2;
  }
  return 2.0 * std::sqrt(distance / acceleration_deg_s2);
}

void CheckTurn(const TurnCommand& command, const AxisFacts& axis, double slack_deg) {
  if (!std::isfinite(command.angle_deg)) {
    throw LimitError(fmt::format("axis.{}: angle {} deg: expected a finite number", axis.name,
                                 command.angle_deg));
  }
  CheckPositive(axis, "rate", "deg/s", command.rate_deg_s, axis.max_rate_deg_s);
  CheckPositive(axis, "acceleration", "deg/s^2", command.acceleration_deg_s2,
                axis.max_acceleration_deg_s2);
  const double end_deg = axis.angle_deg + command.angle_deg;
  const bool below = !(end_deg >= axis.min_deg - slack_deg);
  if (!below && end_deg <= axis.max_deg + slack_deg) return;
  throw LimitError(fmt::format(
      "axis.{}: {:.10g} deg is beyond the soft limit {:.10g} deg (a turn of {:.10g} deg from "
      "{:.10g} deg); turn by less, or turn the axis back first",
      axis.name, end_deg, below ? axis.min_deg : axis.max_deg, command.angle_deg, axis.angle_deg));
}

std::vector<TurnCommand> MovesOf(const SwingCommand& command) {
  constexpr int kMostPeriods = 10'000;
  const double amplitude = command.amplitude_deg, frequency = command.frequency_hz;
  const bool positive = amplitude > 0.0 && frequency > 0.0;
  if (!positive || !std::isfinite(amplitude * frequency * frequency) || command.periods < 1 ||
      command.periods > kMostPeriods) {
    throw LimitError(
        fmt::format("axis.{}: a swing of {:.10g} deg at {:.10g} Hz over {} periods: expected an "
                    "amplitude and a "
                    "frequency above 0 and 1 .. {} periods",
                    command.axis, amplitude, frequency, command.periods, kMostPeriods));
  }
  const double rate = 6.0 * amplitude * frequency, acceleration = rate * 6.0 * frequency;
  std::vector<TurnCommand> moves = {{command.axis, amplitude, rate, acceleration}};
  double side = 1.0;
  for (int half = 1; half < 2 * command.periods; ++half, side = -side)
    moves.push_back({command.axis, -2.0 * side * amplitude, rate, acceleration});
  moves.push_back({command.axis, -side * amplitude, rate, acceleration});
  return moves;
}

double SwingRoom_deg(const AxisFacts& axis, double frequency_hz) {
  if (!(frequency_hz > 0.0) || !std::isfinite(frequency_hz)) {
    throw LimitError(fmt::format("axis.{}: a swing at {:.10g} Hz: expected a frequency above 0",
                                 axis.name, frequency_hz));
  }
  // Of an amplitude of 1 deg.
  const TurnCommand unit = MovesOf({axis.name, 1.0, frequency_hz, 1}).front();
  const double room = std::min({axis.max_deg - axis.angle_deg, axis.angle_deg - axis.min_deg,
                                axis.max_rate_deg_s / unit.rate_deg_s,
                                axis.max_acceleration_deg_s2 / unit.acceleration_deg_s2});
  constexpr double kRounding = 1e-9;
  return std::max(0.0, room * (1.0 - kRounding));
}

void CheckRest(double duration_s) { CheckDuration("duration_s", duration_s, kMaxWait_s); }

void CheckSoak(const SoakCommand& command) {
  CheckDuration("max_s", command.max_s, kMaxWait_s);
  CheckDuration("min_s", command.min_s, command.max_s);
  if (!(command.drift_degC > 0.0) || !std::isfinite(command.drift_degC)) {
    throw LimitError(
        fmt::format("drift_degC = {:.10g} degC: expected a number above 0", command.drift_degC));
  }
  if (!(command.window_s > 0.0) || command.window_s > command.max_s) {
    throw LimitError(fmt::format(
        "window_s = {:.10g} s: expected a number above 0 and not above max_s = {:.10g} s",
        command.window_s, command.max_s));
  }
}

const AxisFacts& FindAxis(const std::vector<AxisFacts>& axes, const std::string& name) {
  const auto found = std::find_if(axes.begin(), axes.end(),
                                  [&](const AxisFacts& axis) { return axis.name == name; });
  if (found != axes.end()) return *found;
  std::vector<std::string> names;
  for (const AxisFacts& axis : axes) names.push_back(axis.name);
  throw LimitError(fmt::format("axis.{}: this stand has no such axis, it has: {}", name,
                               fmt::join(names, ", ")));
}

}  // namespace gyrobench::procedures
