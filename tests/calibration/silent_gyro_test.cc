// The gyro falls silent at some moment of a run, and the reference goes on: what is shown then is
// right, or is not shown.
#include <gtest/gtest.h>

#include <cmath>

#include "calibration/estimators/analyzer.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::calibration {
namespace {

using gyrobench::testing::PassedOn;
using gyrobench::testing::SimulatedSensor;
using gyrobench::testing::TurnSchedule;

class UntilSilent : public PassedOn {
 public:
  UntilSilent(MeasurementSink& sink, double silent_from_s)
      : PassedOn(sink), silent_from_s_(silent_from_s) {}
  void OnGyro(const GyroSample& sample) override {
    if (sample.t_s < silent_from_s_) PassedOn::OnGyro(sample);
  }

 private:
  double silent_from_s_;
};

// Every rest and turn ends somewhere behind the moment at which the gyro ended, by up to three
// turns.
TEST(SilentGyro, NoScaleFactorIsOffByMoreThanItsErrorsSay) {
  const TurnSchedule schedule = {.turns = 7};
  const SimulatedSensor sensor;
  const double cycle_s = schedule.rest_s + schedule.TurnTime();
  int shown = 0;
  for (double silent_from_s = 3.5 * cycle_s; silent_from_s < 5.0 * cycle_s; silent_from_s += 0.04) {
    Analyzer analyzer;
    UntilSilent sink(analyzer, silent_from_s);
    SimulateTurns(schedule, sensor, 3, &sink, [&] {
      for (const ScaleResult& scale : analyzer.Result().scale) {
        if (!(scale.alpha_std_error > 0.0)) continue;
        ++shown;
        EXPECT_LT(std::fabs(scale.alpha - sensor.alpha()), 6.0 * scale.alpha_std_error)
            << "silent from " << silent_from_s << " s";
      }
    });
  }
  EXPECT_GT(shown, 100);
}

}  // namespace
}  // namespace gyrobench::calibration
