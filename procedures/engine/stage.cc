#include "procedures/engine/stage.h"

#include <utility>

#include "base/error.h"

namespace gyrobench::procedures {

void Stage::Begin() {
  if (rehearsal_) throw Error("a rehearsal is on: end it with bench.rehearsed first");
  DryOptions options;
  options.geometry = real_.Geometry();
  begin_axes_ = real_.Axes();
  rehearsal_ = std::make_unique<DryBench>(begin_axes_, options);
}

bool Stage::End(const std::string& name, double warms_degC, double at_most_s) {
  if (!rehearsal_) throw Error("no rehearsal is on: begin one with bench.rehearse");
  const std::unique_ptr<DryBench> done = std::move(rehearsal_);
  const Plan& plan = done->plan();
  if (plan.duration_s > at_most_s) return false;
  menu_.push_back({name, plan.duration_s, warms_degC, std::move(begin_axes_), plan.moves});
  return true;
}

std::vector<Rehearsal> Stage::TakeMenu() { return std::exchange(menu_, {}); }

}  // namespace gyrobench::procedures
