// A wave of the angle at a node that is the mean of several readings.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "calibration/effects/effect.h"
#include "calibration/state/sensor_state.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kAxis = 2;
constexpr double kRadPerDegree = 0.017453292519943295;

// Readings of an axis about `table_deg`, each `step_deg` on from the one before and off by up to
// `uneven_deg`.
std::vector<double> Readings(std::size_t count, double step_deg, double uneven_deg,
                             std::mt19937_64& random) {
  std::uniform_real_distribution<double> uneven(-uneven_deg, uneven_deg);
  std::vector<double> off_deg(count);
  double mean_deg = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    off_deg[i] = step_deg * static_cast<double>(i) + uneven(random);
    mean_deg += off_deg[i] / static_cast<double>(count);
  }
  for (double& each : off_deg) each -= mean_deg;
  return off_deg;
}

TEST(WaveOverReadings, IsTheMeanOfTheWaveAtEachOfThem) {
  std::mt19937_64 random(3);
  BasisContext context;
  context.table_axis = kAxis;
  for (const double periods : {7.0, 120.0, 720.0, 5000.0}) {
    for (const double uneven_deg : {0.0, 0.01, 0.3}) {
      for (const double step_deg : {-0.4, 0.05, 2.0}) {
        const std::vector<double> off_deg = Readings(50, step_deg, uneven_deg, random);
        SensorState node;
        node.table_deg[kAxis] = 123.4;
        node.readings = off_deg.size();
        node.reading_step_deg[kAxis] = step_deg;
        node.readings_off_mean_deg[kAxis] = off_deg;
        context.nonlinear = {periods};
        std::array<double, 2> mean = {}, shown = {};
        for (const double each : off_deg) {
          const double phase = periods * kRadPerDegree * (node.table_deg[kAxis] + each);
          mean[0] += std::sin(phase) / static_cast<double>(off_deg.size());
          mean[1] += std::cos(phase) / static_cast<double>(off_deg.size());
        }
        FindEffect("angle.ripple")->basis(context)->At(node, shown.data());
        // Where all readings span less than a radian of the wave they count as evenly spaced.
        const double span_rad = periods * kRadPerDegree * std::fabs(step_deg) * 50.0;
        const double within = 1e-6 + (span_rad > 1.0 ? 0.0 : periods * kRadPerDegree * uneven_deg);
        EXPECT_NEAR(shown[0], mean[0], within) << periods << " " << uneven_deg << " " << step_deg;
        EXPECT_NEAR(shown[1], mean[1], within) << periods << " " << uneven_deg << " " << step_deg;
      }
    }
  }
}

// In a steady turn a wave that is nearly the same from node to node is to the nodes one of few
// periods a turn, as of 180 where they are 2 deg apart, and takes the part of their own readings
// that such a wave needs. Any other does not.
TEST(WaveOfTheAngle, IsALongOneWhereItIsNearlyTheSameAtEachNode) {
  constexpr double kOwn_deg = 0.01;
  BasisContext context;
  context.table_axis = kAxis;
  for (const double step_deg : {2.0, -2.0}) {
    for (const double periods :
         {1.0, 181.0, 179.0, 360.0, 357.0, 363.0, 60.0, 90.0, 200.0, 365.0}) {
      context.nonlinear = {periods};
      for (const std::size_t readings : {1u, 2u}) {
        std::mt19937_64 random(5);
        const std::vector<double> off_deg = Readings(readings, step_deg / 10.0, 0.0, random);
        const auto at = [&](double table_deg, double own_deg) {
          SensorState node;
          node.table_deg[kAxis] = table_deg;
          node.own_part_deg[kAxis] = own_deg;
          node.steady_step_deg[kAxis] = step_deg;
          node.readings = readings;
          node.reading_step_deg[kAxis] = step_deg / 10.0;
          node.readings_off_mean_deg[kAxis] = off_deg;
          std::array<double, 2> shown = {};
          FindEffect("angle.ripple")->basis(context)->At(node, shown.data());
          return shown;
        };
        const bool few = std::fabs(std::remainder(periods, 180.0)) < 4.0;
        const auto without = at(33.3, 0.0), with = at(33.3, kOwn_deg);
        const auto moved = at(33.3 + kOwn_deg, 0.0);
        for (std::size_t term = 0; term < 2; ++term) {
          EXPECT_GT(std::fabs(moved[term] - without[term]), 1e-6) << periods;
          EXPECT_NEAR(with[term], few ? moved[term] : without[term], 1e-9)
              << periods << " periods, " << readings << " readings";
        }
      }
    }
  }
}

}  // namespace
}  // namespace gyrobench::calibration
