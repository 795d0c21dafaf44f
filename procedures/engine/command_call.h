// What the commands of a script have in common. For the sources of the engine.
#pragma once

#include <lua.hpp>
#include <string>
#include <utility>
#include <vector>

#include "procedures/engine/bench.h"
#include "procedures/engine/commands.h"
#include "procedures/engine/table_reader.h"

namespace gyrobench::procedures {

// One command as it is executed: the script's argument, the bench, and the stack for the outcome.
struct Call {
  lua_State* state;
  int argument;             // index on the stack
  const std::string& name;  // "bench.turn"
  Bench& bench;             // the rehearsal's while there is one
  std::vector<LimitCheck>& checks;
  Stage& stage;

  TableReader Fields(std::vector<std::string> known) const {
    return {state, argument, name, std::move(known)};
  }
  std::string Text() const { return ReadText(state, argument, name); }
  void CheckNothing() const;
};

inline void SetField(lua_State* state, const char* field, double value) {
  lua_pushnumber(state, value);
  lua_setfield(state, -2, field);
}

// Not called SetField: a `const char*` would convert to bool.
inline void SetFlag(lua_State* state, const char* field, bool value) {
  lua_pushboolean(state, value ? 1 : 0);
  lua_setfield(state, -2, field);
}

inline void SetField(lua_State* state, const char* field, const std::string& value) {
  lua_pushlstring(state, value.data(), value.size());
  lua_setfield(state, -2, field);
}

inline void PushText(lua_State* state, const std::string& text) {
  lua_pushlstring(state, text.data(), text.size());
}

// A list of what `push` pushes for each of `items`, as field `field` of the table on top.
template <typename Item>
void SetList(lua_State* state, const char* field, const std::vector<Item>& items,
             void (*push)(lua_State* state, const Item& item)) {
  lua_createtable(state, static_cast<int>(items.size()), 0);
  lua_Integer place = 0;
  for (const Item& item : items) {
    push(state, item);
    lua_rawseti(state, -2, ++place);
  }
  lua_setfield(state, -2, field);
}

// Each of these executes one command and returns the number of values that it pushed.
int Rest(const Call& call);
int Turn(const Call& call);
int MoveTo(const Call& call);
int Swing(const Call& call);
int SwingRoom(const Call& call);
int FindPose(const Call& call);
int TakePose(const Call& call);
int Soak(const Call& call);
int ListOutputs(const Call& call);
int Switch(const Call& call);
int Rehearse(const Call& call);
int Rehearsed(const Call& call);
int Choose(const Call& call);
int FindWiring(const Call& call);
int WriteStandFile(const Call& call);

}  // namespace gyrobench::procedures
