#include "procedures/engine/stage.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "procedures/engine/script_error.h"

namespace gyrobench::procedures {
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
