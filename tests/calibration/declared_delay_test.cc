// What is declared is known: a delay that the map of a device states is taken off, and is no
// effect.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "calibration/signal/collector.h"
#include "tests/calibration/passed_on.h"
#include "tests/calibration/simulated_run.h"

namespace gyrobench::calibration {
namespace {

using gyrobench::testing::PassedOn;
using gyrobench::testing::SimulatedSensor;
using gyrobench::testing::SimulateTurns;

// Stamps that come later than the values that they belong to.
class Delayed final : public PassedOn {
 public:
  Delayed(MeasurementSink& sink, double gyro_s, double reference_s, bool declared)
      : PassedOn(sink), gyro_s_(gyro_s), reference_s_(reference_s), declared_(declared) {}
  void OnInfo(const MeasurementInfo& info) override {
    MeasurementInfo mine = info;
    if (declared_) {
      mine.gyro_delay_s = gyro_s_;
      mine.reference_delay_s = reference_s_;
    }
    PassedOn::OnInfo(mine);
  }
  void OnGyro(const GyroSample& sample) override {
    GyroSample late = sample;
    late.t_s += gyro_s_;
    PassedOn::OnGyro(late);
  }
  void OnAngle(const AngleSample& sample) override {
    AngleSample late = sample;
    late.t_s += reference_s_;
    PassedOn::OnAngle(late);
  }

 private:
  const double gyro_s_, reference_s_;
  const bool declared_;
};

Recording Collected(double gyro_s, double reference_s, bool declared) {
  Collector collector;
  Delayed delayed(collector, gyro_s, reference_s, declared);
  SimulateTurns({}, {}, 3, &delayed);
  // A copy is asked, as the daemon does after each segment.
  const Collector copy = collector;
  return copy.Take();
}

// Largest difference of the angles that two recordings of one run have seen, at the same nodes.
double LargestDifference(const Recording& a, const Recording& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < std::min(a.columns.nodes.size(), b.columns.nodes.size()); ++i) {
    largest = std::max(largest, std::abs(a.columns.nodes[i].at.z[2] - b.columns.nodes[i].at.z[2]));
  }
  return largest;
}

// The law: a declared delay changes the stamps and nothing else. Powers of two, so that the sums of
// times are exact to the last digits.
TEST(DeclaredDelay, LeavesTheColumnsOfTheRunWithoutIt) {
  const Recording plain = Collected(0.0, 0.0, true);
  const double lsb_s = SimulatedSensor{}.nominal_lsb_per_deg_s;  // of one degree
  for (const auto& [gyro_s, reference_s] :
       {std::pair{0.0078125, 0.0}, {0.0, 0.00390625}, {0.0078125, 0.00390625}}) {
    const Recording declared = Collected(gyro_s, reference_s, true);
    EXPECT_EQ(plain.columns.nodes.size(), declared.columns.nodes.size());
    EXPECT_EQ(plain.columns.rests.size(), declared.columns.rests.size());
    EXPECT_LT(LargestDifference(plain, declared), 1e-6 * lsb_s);
    // 7.8 ms at 20 deg/s are 0.16 deg, and the test would see them.
    EXPECT_GT(LargestDifference(plain, Collected(gyro_s, reference_s, false)), 0.02 * lsb_s);
  }
}

}  // namespace
}  // namespace gyrobench::calibration
