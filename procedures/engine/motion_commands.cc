#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "procedures/engine/command_call.h"
#include "procedures/engine/motion_time.h"

namespace gyrobench::procedures {
namespace {

// About the smallest step of a drive behind a worm: a table nearer to its target than this is
// there.
constexpr double kThere_deg = 0.001;

int PushOutcome(lua_State* state, const TurnOutcome& outcome) {
  lua_createtable(state, 0, 3);
  SetField(state, "moved_deg", outcome.moved_deg);
  SetField(state, "rate_deg_s", outcome.rate_deg_s);
  SetField(state, "duration_s", outcome.duration_s);
  return 1;
}

TurnCommand ReadMove(const TableReader& fields, const AxisFacts& axis) {
  TurnCommand command;
  command.axis = axis.name;
  command.rate_deg_s = fields.RequiredNumber("rate_deg_s");
  command.acceleration_deg_s2 =
      fields.Number("acceleration_deg_s2").value_or(0.5 * axis.max_acceleration_deg_s2);
  return command;
}

}  // namespace

int Rest(const Call& call) {
  const double duration_s = call.Fields({"duration_s"}).RequiredNumber("duration_s");
  CheckRest(duration_s);
  if (duration_s > 0.0) call.bench.Rest(duration_s);
  return 0;
}

int Turn(const Call& call) {
  const TableReader fields =
      call.Fields({"axis", "angle_deg", "shaft_turns", "rate_deg_s", "acceleration_deg_s2"});
  const auto axes = call.bench.Axes();
  const AxisFacts& axis = FindAxis(axes, fields.RequiredText("axis"));
  TurnCommand command = ReadMove(fields, axis);
  if (fields.Has("angle_deg") == fields.Has("shaft_turns")) {
    fields.Refuse("expected either angle_deg (of the table) or shaft_turns");
  }
  command.angle_deg = fields.Has("angle_deg")
                          ? fields.RequiredNumber("angle_deg")
                          : 360.0 * fields.RequiredNumber("shaft_turns") / axis.gear_ratio;
  if (command.angle_deg == 0.0) fields.Refuse("a turn by 0 deg is none");
  return PushOutcome(call.state, call.bench.Turn(command));
}

int MoveTo(const Call& call) {
  const TableReader fields =
      call.Fields({"axis", "angle_deg", "rate_deg_s", "acceleration_deg_s2"});
  const auto axes = call.bench.Axes();
  const AxisFacts& axis = FindAxis(axes, fields.RequiredText("axis"));
  TurnCommand command = ReadMove(fields, axis);
  command.angle_deg = fields.RequiredNumber("angle_deg") - axis.angle_deg;
  if (std::abs(command.angle_deg) < kThere_deg) {
    return PushOutcome(call.state, {0.0, command.rate_deg_s, 0.0});
  }
  return PushOutcome(call.state, call.bench.Turn(command));
}

int Swing(const Call& call) {
  const TableReader fields = call.Fields({"axis", "amplitude_deg", "frequency_hz", "periods"});
  const auto axes = call.bench.Axes();
  SwingCommand command;
  command.axis = FindAxis(axes, fields.RequiredText("axis")).name;
  command.amplitude_deg = fields.RequiredNumber("amplitude_deg");
  command.frequency_hz = fields.RequiredNumber("frequency_hz");
  const double periods = fields.RequiredNumber("periods");
  if (periods != std::floor(periods) || periods < 1.0 || periods > 10'000.0)
    fields.Refuse(fmt::format("periods = {:.10g}: expected a whole number, 1 .. 10000", periods));
  command.periods = static_cast<int>(periods);
  const SwingOutcome outcome = call.bench.Swing(command);
  lua_createtable(call.state, 0, 2);
  SetField(call.state, "frequency_hz", outcome.frequency_hz);
  SetField(call.state, "duration_s", outcome.duration_s);
  return 1;
}

int SwingRoom(const Call& call) {
  const TableReader fields = call.Fields({"axis", "frequency_hz", "angle_deg"});
  const auto axes = call.bench.Axes();
  AxisFacts axis = FindAxis(axes, fields.RequiredText("axis"));
  axis.angle_deg = fields.Number("angle_deg").value_or(axis.angle_deg);
  lua_pushnumber(call.state, SwingRoom_deg(axis, fields.RequiredNumber("frequency_hz")));
  return 1;
}

int Soak(const Call& call) {
  const TableReader fields = call.Fields({"drift_degC", "window_s", "min_s", "max_s"});
  SoakCommand command;
  command.drift_degC = fields.Number("drift_degC").value_or(command.drift_degC);
  command.window_s = fields.Number("window_s").value_or(command.window_s);
  command.min_s = fields.Number("min_s").value_or(command.min_s);
  command.max_s = fields.RequiredNumber("max_s");
  CheckSoak(command);
  const SoakOutcome outcome = call.bench.Soak(command);
  lua_createtable(call.state, 0, 3);
  lua_pushboolean(call.state, outcome.settled ? 1 : 0);
  lua_setfield(call.state, -2, "settled");
  SetField(call.state, "temperature_degC", outcome.temperature_degC);
  SetField(call.state, "duration_s", outcome.duration_s);
  return 1;
}

}  // namespace gyrobench::procedures
