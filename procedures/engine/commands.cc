#include "procedures/engine/commands.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "procedures/engine/command_call.h"
#include "procedures/engine/sandbox.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {

void Call::CheckNothing() const {
  if (lua_isnil(state, argument)) return;
  throw ScriptError(fmt::format("{}: takes nothing, got {}", name, ShowValue(state, argument)));
}

namespace {

// Each of the following executes one command and returns the number of values that it pushed.

int Ask(const Call& call) {
  const TableReader fields = call.Fields({"id", "text", "choices", "timeout_s"});
  Question question;
  question.id = fields.RequiredText("id");
  question.text = fields.RequiredText("text");
  question.choices = fields.Texts("choices");
  question.timeout_s = fields.PositiveNumber("timeout_s").value_or(question.timeout_s);
  const std::string answer = call.bench.Ask(question);
  lua_pushlstring(call.state, answer.data(), answer.size());
  return 1;
}

int ReadEstimate(const Call& call) {
  const std::vector<std::string> known = {"scale_factor", "bias"};
  const std::string what = call.Text();
  if (what != known[0] && what != known[1]) {
    throw ScriptError(fmt::format("{}: \"{}\" is not known{}; known: {}", call.name, what,
                                  DidYouMean(what, known), fmt::join(known, ", ")));
  }
  const Estimate estimate = call.bench.ReadEstimate(what);
  if (!estimate.available) {
    lua_pushnil(call.state);
    return 1;
  }
  lua_createtable(call.state, 0, 3);
  SetField(call.state, "value", estimate.value);
  SetField(call.state, "std_error", estimate.std_error);
  SetField(call.state, "unit", estimate.unit);
  return 1;
}

void PushParameter(lua_State* state, const TracedParameter& parameter) {
  lua_createtable(state, 0, 4);
  SetField(state, "name", parameter.name);
  SetField(state, "value", parameter.value);
  SetField(state, "std_error", parameter.std_error);
  SetField(state, "unit", parameter.unit);
}

void PushEffect(lua_State* state, const TracedEffect& effect) {
  lua_createtable(state, 0, 6);
  SetField(state, "id", effect.id);
  SetField(state, "owner", effect.owner);
  SetField(state, "settled_by", effect.settled_by);
  SetFlag(state, "may_be_a_step", effect.may_be_a_step);
  SetList(state, "parameters", effect.parameters, PushParameter);
  SetList(state, "rivals", effect.rivals, PushText);
}

int Trace(const Call& call) {
  call.CheckNothing();
  const std::vector<AxisVerdict> verdicts = call.bench.Trace();
  if (verdicts.empty()) {
    lua_pushnil(call.state);
    return 1;
  }
  lua_newtable(call.state);
  for (const AxisVerdict& verdict : verdicts) {
    lua_createtable(call.state, 0, 4);
    SetField(call.state, "axis", verdict.axis);
    SetField(call.state, "verdict", verdict.verdict);
    SetField(call.state, "summary", verdict.summary);
    SetList(call.state, "effects", verdict.effects, PushEffect);
    lua_setfield(call.state, -2, verdict.axis.c_str());
  }
  return 1;
}

int Temperature(const Call& call) {
  const double temperature = call.bench.TemperatureDegC();
  if (std::isnan(temperature)) {
    lua_pushnil(call.state);
  } else {
    lua_pushnumber(call.state, temperature);
  }
  return 1;
}

int Elapsed(const Call& call) {
  lua_pushnumber(call.state, call.bench.ElapsedS());
  return 1;
}

int ListAxes(const Call& call) {
  lua_newtable(call.state);
  for (const AxisFacts& axis : call.bench.Axes()) {
    lua_createtable(call.state, 0, 7);
    SetField(call.state, "name", axis.name);
    SetField(call.state, "gear_ratio", axis.gear_ratio);
    SetField(call.state, "angle_deg", axis.angle_deg);
    SetField(call.state, "min_deg", axis.min_deg);
    SetField(call.state, "max_deg", axis.max_deg);
    SetField(call.state, "max_rate_deg_s", axis.max_rate_deg_s);
    SetField(call.state, "max_acceleration_deg_s2", axis.max_acceleration_deg_s2);
    lua_setfield(call.state, -2, axis.name.c_str());
  }
  return 1;
}

int Say(const Call& call) {
  call.bench.Say(call.Text());
  return 0;
}

int Progress(const Call& call) {
  const bool number = lua_type(call.state, call.argument) == LUA_TNUMBER;
  const double fraction = number ? lua_tonumber(call.state, call.argument) : -1.0;
  if (!(fraction >= 0.0 && fraction <= 1.0)) {
    throw ScriptError(fmt::format("{}: expected a number 0 .. 1, got {}", call.name,
                                  ShowValue(call.state, call.argument)));
  }
  call.bench.Progress(fraction);
  return 0;
}

int FailRun(const Call& call) { throw ScriptError(call.Text()); }

int Limit(const Call& call) {
  const TableReader fields = call.Fields({"name", "value", "min", "max", "unit"});
  LimitCheck check;
  check.name = fields.RequiredText("name");
  const auto value = fields.AnyNumber("value");
  if (!value) fields.Refuse("value is missing: expected a number");
  if (!fields.Has("min") && !fields.Has("max")) fields.Refuse("expected min, max or both");
  check.value = *value;
  check.min = fields.Number("min").value_or(check.min);
  check.max = fields.Number("max").value_or(check.max);
  check.unit = fields.Text("unit").value_or("");
  if (check.min > check.max) {
    fields.Refuse(fmt::format("min = {:.10g} is above max = {:.10g}", check.min, check.max));
  }
  check.passed = check.value >= check.min && check.value <= check.max;
  call.checks.push_back(check);
  call.bench.RecordLimit(check);
  lua_pushboolean(call.state, check.passed ? 1 : 0);
  return 1;
}

struct Command {
  const char* name;
  int (*execute)(const Call& call);
};

// One line a command.
constexpr Command kCommands[] = {
    {"rest", Rest},
    {"turn", Turn},
    {"move_to", MoveTo},
    {"soak", Soak},
    {"ask", Ask},
    {"estimate", ReadEstimate},
    {"elapsed", Elapsed},
    {"axes", ListAxes},
    {"temperature", Temperature},
    {"outputs", ListOutputs},
    {"switch", Switch},
    {"say", Say},
    {"limit", Limit},
    {"progress", Progress},
    {"fail", FailRun},
    {"trace", Trace},
    {"swing", Swing},
    {"swing_room", SwingRoom},
    {"find_pose", FindPose},
    {"take_pose", TakePose},
    {"rehearse", Rehearse},
    {"rehearsed", Rehearsed},
    {"choose", Choose},
    {"find_wiring", FindWiring},
    {"write_stand_file", WriteStandFile},
};

// The C side of every function of `bench`: yields its argument and the command's index to the host.
// Upvalues: index, the table bench.
int Yield(lua_State* state) {
  const lua_Integer index = lua_tointeger(state, lua_upvalueindex(1));
  const char* name = kCommands[index].name;
  if (lua_rawequal(state, 1, lua_upvalueindex(2)) != 0) {
    return luaL_error(state, "bench:%s: write bench.%s, with a dot", name, name);
  }
  if (lua_gettop(state) > 1) {
    return luaL_error(state, "bench.%s takes one value, got %d", name, lua_gettop(state));
  }
  if (lua_isyieldable(state) == 0) {
    return luaL_error(state, "bench.%s cannot be called from within table.sort", name);
  }
  lua_settop(state, 1);
  lua_pushinteger(state, index);
  return lua_yield(state, 2);
}

int RefuseUnknown(lua_State* state) {
  const char* name = luaL_tolstring(state, 2, nullptr);
  const char* hint = lua_tostring(state, lua_upvalueindex(1));
  return luaL_error(state, "bench.%s: there is no such command; commands: %s", name, hint);
}

}  // namespace

void InstallCommands(lua_State* state) {
  lua_newtable(state);
  for (std::size_t i = 0; i < std::size(kCommands); ++i) {
    lua_pushinteger(state, static_cast<lua_Integer>(i));
    lua_pushvalue(state, -2);
    lua_pushcclosure(state, Yield, 2);
    lua_setfield(state, -2, kCommands[i].name);
  }
  lua_newtable(state);
  lua_pushstring(state, fmt::format("{}", fmt::join(CommandNames(), ", ")).c_str());
  lua_pushcclosure(state, RefuseUnknown, 1);
  lua_setfield(state, -2, "__index");
  lua_setmetatable(state, -2);
  lua_setglobal(state, "bench");
}

std::vector<std::string> CommandNames() {
  std::vector<std::string> names;
  for (const Command& command : kCommands) names.emplace_back(command.name);
  return names;
}

std::string CommandName(lua_State* thread) {
  return std::string("bench.") + kCommands[lua_tointeger(thread, -1)].name;
}

int ExecuteCommand(lua_State* thread, int values, Stage& stage, std::vector<LimitCheck>& checks) {
  const int first = lua_gettop(thread) - values + 1;
  const Command& command = kCommands[lua_tointeger(thread, -1)];
  const std::string name = CommandName(thread);
  const int results = command.execute({thread, first, name, stage.bench(), checks, stage});
  for (int i = 0; i < values; ++i) lua_remove(thread, first);
  return results;
}

namespace {

constexpr double kLimitReading_deg = 0.1;

}  // namespace

void Stage::Begin() {
  if (rehearsal_) throw ScriptError("a rehearsal is on: end it with bench.rehearsed first");
  DryOptions options;
  options.geometry = real_.Geometry();
  options.outputs = real_.Outputs();
  begin_axes_ = real_.Axes();
  // An axis at its limit reads a little beyond it now and then.
  for (AxisFacts& axis : begin_axes_) {
    const double within = std::clamp(axis.angle_deg, axis.min_deg, axis.max_deg);
    if (std::fabs(axis.angle_deg - within) <= kLimitReading_deg) axis.angle_deg = within;
  }
  rehearsal_ = std::make_unique<DryBench>(begin_axes_, options);
}

bool Stage::End(const std::string& name, double warms_degC, double at_most_s) {
  if (!rehearsal_) throw ScriptError("no rehearsal is on: begin one with bench.rehearse");
  const std::unique_ptr<DryBench> done = std::move(rehearsal_);
  const Plan& plan = done->plan();
  const bool affordable = plan.duration_s <= at_most_s;
  menu_.push_back({name, plan.duration_s, affordable, at_most_s, warms_degC, std::move(begin_axes_),
                   plan.moves});
  return affordable;
}

std::vector<Rehearsal> Stage::TakeMenu() {
  if (rehearsal_) throw ScriptError("a rehearsal is on: end it with bench.rehearsed first");
  if (menu_.empty()) throw ScriptError("nothing was rehearsed: there is nothing to choose from");
  return std::exchange(menu_, {});
}

}  // namespace gyrobench::procedures
