// The delay between gyro and reference is another in one of several runs.
#include <algorithm>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/turned_on.h"

namespace gyrobench::calibration {
namespace {

constexpr double kMostRuns = 20.0;  // that are looked at

// -w in that run, 0 in all others.
class LatencyOfRunBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    constexpr double kShort_s = 1e-5;
    if (point.begins) run_ = static_cast<double>(point.run);
    terms[0] = run_ == context().nonlinear[0]
                   ? -TurnedOn(point, context().channel, kShort_s) / kShort_s
                   : 0.0;
  }

 private:
  double run_ = 0.0;
};

std::vector<double> AllRuns() {
  std::vector<double> runs;
  for (double run = 1.0; run <= kMostRuns; run += 1.0) runs.push_back(run);
  return runs;
}

// What angle.latency says is that of the first run that turns.
bool TurnsAfterAnother(const DataRange& data, const std::vector<double>& nonlinear) {
  const auto run = static_cast<std::size_t>(nonlinear[0]) - 1;
  if (run >= data.turns_in_run.size() || !data.turns_in_run[run]) return false;
  const auto begin = data.turns_in_run.begin(), it = begin + static_cast<std::ptrdiff_t>(run);
  return std::find(begin, it, true) != it;
}

}  // namespace

Effect AngleLatencyOfRun() {
  return {.id = "angle.latency_of_run",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-tau w in one run of those that were given, beside the first's",
          .cause =
              "readings of the reference that are taken at another moment of its refresh than in "
              "the first run; another filter or bus",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, in one run by more "
              "or less than in the first (20 runs are looked at)",
          .manoeuvre = "repeat a motion within one run and in another",
          .needs = kNeedsRate,
          .terms = {{"tau", "s"}},
          .nonlinear = {{"run", "1", 0.0, 0.0, AllRuns()}},
          .search = Search::kEachPoint,
          .typical_size = 0.02,
          .size_source = "that of angle.latency",
          .differs_in_one_run = "angle.latency",
          .makes_sense = TurnsAfterAnother,
          .basis = Make<LatencyOfRunBasis>};
}

}  // namespace gyrobench::calibration
