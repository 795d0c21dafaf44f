#include <limits>
#include <string>

#include "procedures/engine/command_call.h"

namespace gyrobench::procedures {

int Rehearse(const Call& call) {
  call.CheckNothing();
  call.stage.Begin();
  return 0;
}

int Rehearsed(const Call& call) {
  const TableReader fields = call.Fields({"name", "warms_degC", "at_most_s"});
  const bool on_menu =
      call.stage.End(fields.RequiredText("name"), fields.Number("warms_degC").value_or(0.0),
                     fields.Number("at_most_s").value_or(std::numeric_limits<double>::infinity()));
  lua_pushboolean(call.state, on_menu ? 1 : 0);
  return 1;
}

namespace {

// small["x angle.ripple"] = true
void PushSmall(lua_State* state, const Choice& choice) {
  lua_newtable(state);
  for (const auto& [axis, id] : choice.small) {
    std::string name = axis;
    name += ' ';
    name += id;
    lua_pushboolean(state, 1);
    lua_setfield(state, -2, name.c_str());
  }
}

}  // namespace

int Choose(const Call& call) {
  double small_below = 0.0;
  if (!lua_isnil(call.state, call.argument))
    small_below = call.Fields({"small_below"}).Number("small_below").value_or(0.0);
  const std::vector<Rehearsal> menu = call.stage.TakeMenu();
  const Choice choice = call.bench.Choose(menu, small_below);
  lua_createtable(call.state, 0, 10);
  lua_pushboolean(call.state, choice.settled ? 1 : 0);
  lua_setfield(call.state, -2, "settled");
  SetField(call.state, "open", choice.open);
  SetField(call.state, "never", choice.never);
  SetField(call.state, "newly_closed", choice.newly_closed);
  SetField(call.state, "small_pairs", choice.small_pairs);
  PushSmall(call.state, choice);
  lua_setfield(call.state, -2, "small");
  if (!choice.best) return 1;
  const Rehearsal& best = menu.at(*choice.best);
  SetField(call.state, "index", static_cast<double>(*choice.best + 1));
  SetField(call.state, "name", best.name);
  SetField(call.state, "duration_s", best.duration_s);
  SetField(call.state, "because", choice.because);
  SetField(call.state, "nats", choice.nats);
  return 1;
}

}  // namespace gyrobench::procedures
