// The global table `bench` of the scripts: names, fields and meaning of its functions
// (procedures/README.md).
#pragma once

#include <string>
#include <vector>

#include "procedures/engine/stage.h"

struct lua_State;

namespace gyrobench::procedures {

// Makes the global `bench`. Its functions do nothing but yield to the host.
void InstallCommands(lua_State* state);

// Names of all functions of `bench`.
std::vector<std::string> CommandNames();

// "bench.turn": the command that `thread` has yielded.
std::string CommandName(lua_State* thread);

// Executes on the stage the command that `thread` yielded with `values` values, and leaves its
// outcome in their place. Returns the number of values of the outcome, to be resumed with. The
// checks of bench.limit are added to `checks`. Throws ScriptError where fields are wrong, and what
// the bench throws.
int ExecuteCommand(lua_State* thread, int values, Stage& stage, std::vector<LimitCheck>& checks);

}  // namespace gyrobench::procedures
