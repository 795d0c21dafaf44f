#include "procedures/engine/engine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <lua.hpp>

#include "procedures/engine/commands.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {
namespace {

void PushNumbers(lua_State* state, const std::string& text) {
  const std::vector<double> numbers = ReadNumbers(text).value_or(std::vector<double>());
  lua_createtable(state, static_cast<int>(numbers.size()), 0);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    lua_pushnumber(state, numbers[i]);
    lua_rawseti(state, -2, static_cast<lua_Integer>(i + 1));
  }
}

void PushValue(lua_State* state, const Parameter& parameter, const Value& value) {
  if (parameter.type == ParameterType::kNumbers) {
    PushNumbers(state, std::get<std::string>(value));
    return;
  }
  if (const auto* text = std::get_if<std::string>(&value)) {
    lua_pushlstring(state, text->data(), text->size());
  } else if (const auto* flag = std::get_if<bool>(&value)) {
    lua_pushboolean(state, *flag ? 1 : 0);
  } else if (parameter.type == ParameterType::kInteger) {
    lua_pushinteger(state, static_cast<lua_Integer>(std::get<double>(value)));
  } else {
    lua_pushnumber(state, std::get<double>(value));
  }
}

void PushParameters(lua_State* state, const ProcedureInfo& info, const Parameters& values) {
  lua_newtable(state);
  for (const Parameter& parameter : info.parameters) {
    PushValue(state, parameter, values.at(parameter.name));
    lua_setfield(state, -2, parameter.name.c_str());
  }
}

class Run {
 public:
  Run(const Procedure& procedure, Bench& bench, const RunHooks& hooks)
      : procedure_(procedure),
        bench_(bench),
        stage_(bench),
        hooks_(hooks),
        sandbox_(procedure.info().file.filename().string(), hooks.limits) {}

  RunResult Execute(const Parameters& parameters) {
    lua_State* thread = sandbox_.thread();
    InstallCommands(thread);
    sandbox_.Load(procedure_.source());
    lua_getglobal(thread, "run");
    PushParameters(thread, procedure_.info(), parameters);
    Sandbox::Step step = sandbox_.Resume(1);
    while (!step.finished) step = sandbox_.Resume(ExecuteOne(step.values));
    if (stage_.rehearsing()) {
      throw ScriptError(sandbox_.file(), 0,
                        "the run ended within a rehearsal: bench.rehearsed is missing");
    }
    bench_.SafePoint();
    return Result();
  }

 private:
  // Executes the command that was yielded; adds the script's position to what goes wrong.
  int ExecuteOne(int values) {
    const int line = sandbox_.CurrentLine();
    try {
      return ExecuteAt(line, values);
    } catch (const Aborted&) {  // what somebody wanted is no mistake of a line
      throw;
    } catch (Error& error) {
      error.SetPlace({sandbox_.file(), line});
      throw;
    }
  }

  int ExecuteAt(int line, int values) {
    if (++commands_ > hooks_.max_commands) {
      throw LimitError(
          fmt::format("more than {} bench commands (an endless loop?)", hooks_.max_commands));
    }
    bench_.SafePoint();
    if (hooks_.on_command) hooks_.on_command(line, CommandName(sandbox_.thread()));
    return ExecuteCommand(sandbox_.thread(), values, stage_, checks_);
  }

  RunResult Result() const {
    const bool passed = std::all_of(checks_.begin(), checks_.end(),
                                    [](const LimitCheck& check) { return check.passed; });
    return {passed ? RunOutcome::kPassed : RunOutcome::kFailedLimits, checks_, commands_,
            sandbox_.instructions()};
  }

  const Procedure& procedure_;
  Bench& bench_;
  Stage stage_;
  const RunHooks& hooks_;
  Sandbox sandbox_;
  std::vector<LimitCheck> checks_;
  std::int64_t commands_ = 0;
};

}  // namespace

RunResult RunProcedure(const Procedure& procedure, const Parameters& parameters, Bench& bench,
                       const RunHooks& hooks) {
  const Parameters checked = CheckParameters(procedure.info(), parameters);
  return Run(procedure, bench, hooks).Execute(checked);
}

}  // namespace gyrobench::procedures
