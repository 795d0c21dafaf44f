// The delay between gyro and reference is another in one of several runs than in the rest.
#include <algorithm>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/shared_bases.h"

namespace gyrobench::calibration {
namespace {

constexpr double kMostRuns = 20.0;  // that are looked at

// -w in that run, 0 in all others.
class LatencyOfRunBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const SensorState& point, double* terms) override {
    if (point.begins) run_ = static_cast<double>(point.run);
    const bool mine = run_ == context().nonlinear[0];
    terms[0] =
        mine ? -TurnedOnWithin(point, context().channel, other_delays_s(point.stamp_s())) : 0.0;
  }

 private:
  double run_ = 0.0;
};

std::vector<double> AllRuns() {
  std::vector<double> runs;
  for (double run = 1.0; run <= kMostRuns; run += 1.0) runs.push_back(run);
  return runs;
}

// Where one run alone turns, its delay is angle.latency.
bool TurnsBesideAnother(const DataRange& data, const std::vector<double>& nonlinear) {
  const auto run = static_cast<std::size_t>(nonlinear[0]) - 1;
  const std::vector<bool>& turns = data.turns_in_run;
  return run < turns.size() && turns[run] && std::count(turns.begin(), turns.end(), true) > 1;
}

}  // namespace

Effect AngleLatencyOfRun() {
  return {.id = "angle.latency_of_run",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-tau w in one run of those that were given, beside that of all",
          .cause =
              "readings of the reference that are taken at another moment of its refresh than in "
              "the other runs; another filter or bus",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, in one run by more "
              "or less than in the others (20 runs are looked at)",
          .manoeuvre = "repeat a motion within one run and in another",
          .needs = kNeedsRate,
          .terms = {{"tau", "s"}},
          .nonlinear = {{"run", "1", 0.0, 0.0, AllRuns()}},
          .search = Search::kEachPoint,
          .typical_size = 0.02,
          .size_source = "that of angle.latency",
          .differs_in_one_run = "angle.latency",
          .makes_sense = TurnsBesideAnother,
          .basis = Make<LatencyOfRunBasis>};
}

}  // namespace gyrobench::calibration
