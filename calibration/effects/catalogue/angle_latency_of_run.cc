// The delay between gyro and reference is another in one of several runs.
#include <algorithm>

#include "calibration/effects/basis.h"
#include "calibration/effects/catalogue/makers.h"
#include "calibration/effects/catalogue/turned_on.h"

namespace gyrobench::calibration {
namespace {

constexpr double kMostRuns = 20.0;

// -w in that run, 0 in all others.
class LatencyOfRunBasis final : public ChannelBasis {
 public:
  using ChannelBasis::ChannelBasis;
  void At(const TrackPoint& point, double* terms) override {
    constexpr double kShort_s = 1e-5;
    if (point.begins) run_ += 1.0;
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

bool IsOneOfSeveral(const DataRange& data, const std::vector<double>& nonlinear) {
  const auto run = static_cast<std::size_t>(nonlinear[0]) - 1;
  return run < data.turns_in_run.size() && data.turns_in_run[run] &&
         std::ranges::count(data.turns_in_run, true) > 1;
}

}  // namespace

Effect AngleLatencyOfRun() {
  return {.id = "angle.latency_of_run",
          .domain = EffectDomain::kAngle,
          .owner = EffectOwner::kBench,
          .equation = "-tau w in one run, in the order of time",
          .cause =
              "readings of the reference that are taken at another moment of its refresh than in "
              "the other runs; another filter or bus",
          .looks_like =
              "the angle errs in proportion to the speed while the table turns, in one of several "
              "runs only",
          .manoeuvre = "repeat a motion within one run and in another",
          .needs = kNeedsRate,
          .terms = {{"tau", "s"}},
          .nonlinear = {{"run", "1", 0.0, 0.0, AllRuns()}},
          .search = Search::kEachPoint,
          .typical_size = 0.02,
          .size_source = "that of angle.latency",
          .of_one_run = true,
          .makes_sense = IsOneOfSeveral,
          .basis = Make<LatencyOfRunBasis>};
}

}  // namespace gyrobench::calibration
