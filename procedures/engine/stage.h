// Where a script's commands go: to the bench, or to a rehearsal that begins where the bench stands.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "procedures/engine/bench.h"
#include "procedures/engine/dry_bench.h"

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

}  // namespace gyrobench::procedures
