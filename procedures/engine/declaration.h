// Reads what a script says of itself.
#pragma once

#include "procedures/engine/procedure.h"

struct lua_State;

namespace gyrobench::procedures {

// Reads the global tables `procedure` and the function `run` of a script that was loaded into
// `state`. Throws Error that names the field; file and name are the caller's.
ProcedureInfo ReadDeclaration(lua_State* state);

}  // namespace gyrobench::procedures
