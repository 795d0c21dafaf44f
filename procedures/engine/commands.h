// The global table `bench` of the scripts: names, fields and meaning of its functions
// (procedures/README.md), and where their commands go: to the bench, or to a rehearsal that begins
// where the bench stands.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "procedures/engine/bench.h"
#include "procedures/engine/dry_bench.h"

struct lua_State;

namespace gyrobench::procedures {

class Stage {
 public:
  explicit Stage(Bench& real) : real_(real) {}

  Bench& bench() {
    if (rehearsal_) return *rehearsal_;
    return real_;
  }
  // Throws ScriptError while one is on.
  void Begin();
  // What was tried since Begin goes on the menu. False where it takes longer than `at_most_s`: it
  // is weighed then, and not chosen. Throws ScriptError without a Begin.
  bool End(const std::string& name, double warms_degC, double at_most_s);
  bool rehearsing() const { return rehearsal_ != nullptr; }
  // Empties it. Throws ScriptError while a rehearsal is on, and where nothing was rehearsed.
  std::vector<Rehearsal> TakeMenu();

 private:
  Bench& real_;
  std::unique_ptr<DryBench> rehearsal_;
  std::vector<AxisFacts> begin_axes_;
  std::vector<Rehearsal> menu_;
};

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
