#include <fmt/format.h>

#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <optional>
#include <span>
#include <string>

#include "base/geometry.h"
#include "calibration/effects/effect.h"
#include "calibration/hold/hold_judgement.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/wrong_unit.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;

// Noise of turns over that of the rests: below it nothing is worth a word.
constexpr double kNoisier = 1.5;
// Scatter from pose to pose over the noise of a mean.
constexpr double kScatters = 3.0;

std::vector<Index> ColumnsFrom(Index first, Index count) {
  std::vector<Index> columns;
  for (Index i = 0; i < count; ++i) columns.push_back(first + i);
  return columns;
}

// The element that is the most standard errors from zero.
Index Largest(const WaldTest& test) {
  Index largest = 0;
  test.values.cwiseQuotient(test.std_errors).cwiseAbs().maxCoeff(&largest);
  return largest;
}

// Further columns beside the fit's own, as seen: nothing where they may as well be zero.
std::optional<WaldTest> SeenBeside(const HeldChain& chain, const HoldFit& fit,
                                   const ModelExtent& extent, double latitude_rad,
                                   const std::vector<Index>& columns, double degrees_of_noise) {
  const LinearModel model = Linearize(chain, fit.state, extent, latitude_rad);
  const ArrowSystem::Solution solution = SolveModel(model, fit.noise);
  if (!solution.positive) return std::nullopt;
  const WaldTest test =
      TestColumns(solution, solution.parameters(columns), columns, degrees_of_noise);
  if (!(test.p_value < kSeen)) return std::nullopt;
  return test;
}

HoldFinding FindingOf(const std::string& name, Index channel, const WaldTest& test) {
  HoldFinding finding;
  finding.test = name;
  finding.channels = std::string(1, "xyz"[channel]);
  finding.p_value = test.p_value;
  return finding;
}

void AddBentGyro(const HeldChain& chain, const HoldFit& fit, double latitude_rad,
                 std::vector<HoldFinding>* out) {
  constexpr std::array<const char*, 3> kShapes = {"differs between the two directions (|w|)",
                                                  "changes evenly with the rate (w^2)",
                                                  "changes with the size of the rate (w |w|)"};
  ModelExtent extent = fit.extent;
  extent.bent_gyro = true;
  const auto test = SeenBeside(chain, fit, extent, latitude_rad,
                               ColumnsFrom(extent.AtBentGyro(), 9), TurnFreedom(fit) - 9.0);
  if (!test) return;
  const Index worst = Largest(*test);
  HoldFinding finding = FindingOf("scale.bent", worst % 3, *test);
  finding.says = fmt::format(
      "the gyro's scale factor is not constant, mostly that of {}, which {}: turn on a stand at "
      "several rates both ways and trace it",
      finding.channels, kShapes.at(static_cast<std::size_t>(worst / 3)));
  out->push_back(finding);
}

void AddBentAccel(const HeldChain& chain, const HoldFit& fit, double latitude_rad,
                  std::vector<HoldFinding>* out) {
  ModelExtent extent = fit.extent;
  extent.bent_accel = true;
  // Each rest tells three numbers, of which two are how the sensor was held.
  const double freedom = static_cast<double>(chain.rests.size()) + TurnFreedom(fit) - 15.0;
  const auto test =
      SeenBeside(chain, fit, extent, latitude_rad, ColumnsFrom(extent.AtBentAccel(), 6), freedom);
  if (!test) return;
  const Index worst = Largest(*test);
  HoldFinding finding = FindingOf("accel.bent", worst % 3, *test);
  finding.says = fmt::format(
      "the accelerometer is not linear, mostly {}: {:.2g} g at 1 g beyond scale and offset ({}); "
      "the matrix takes it for a straight one",
      finding.channels, test->values[worst], worst < 3 ? "even, a^2" : "odd, a^3");
  out->push_back(finding);
}

void AddTurnNoise(const HoldFit& fit, const RestNoise& rests, std::vector<HoldFinding>* out) {
  const double ratio =
      fit.noise.angle_random_walk_deg_sqrt_s / rests.median_angle_random_walk_deg_sqrt_s;
  if (!(ratio > kNoisier)) return;
  const double freedom = TurnFreedom(fit);
  const boost::math::chi_squared law(freedom);
  const double p = boost::math::cdf(boost::math::complement(law, freedom * ratio * ratio));
  if (!(p < kSeen)) return;
  HoldFinding finding;
  finding.test = "turn_noise";
  finding.p_value = p;
  finding.says = fmt::format(
      "turns scatter {:.1f} times more than the gyro's noise at rest explains ({:.2g} against "
      "{:.2g} deg/sqrt(s)): time stamps that jitter, samples that were lost, a scale factor that "
      "is "
      "not constant, or a sensor that is loose; the errors here count the larger one",
      ratio, fit.noise.angle_random_walk_deg_sqrt_s, rests.median_angle_random_walk_deg_sqrt_s);
  out->push_back(finding);
}

void AddPoseScatter(const HeldChain& chain, const HoldFit& fit, std::vector<HoldFinding>* out) {
  double length_s = 0.0;
  for (const HeldRest& rest : chain.rests)
    length_s += rest.duration_s() / static_cast<double>(chain.rests.size());
  const double mean_g = fit.noise.accel_density_g_sqrt_s / std::sqrt(length_s);
  if (!(fit.noise.pose_scatter_g > kScatters * mean_g)) return;
  HoldFinding finding;
  finding.test = "pose_scatter";
  finding.says = fmt::format(
      "the accelerometer's means scatter by {:.2g} mg from pose to pose, its noise within a rest "
      "explains {:.2g} mg: a hand that pulls, a temperature that changes, or an accelerometer that "
      "is not linear; the errors here count it",
      1e3 * fit.noise.pose_scatter_g, 1e3 * mean_g);
  out->push_back(finding);
}

}  // namespace

std::vector<HoldFinding> GSensitivitySeen(const HoldFit& fit) {
  std::vector<HoldFinding> out;
  for (Index c = 0; c < 3; ++c) {
    const std::vector<Index> columns = ColumnsFrom(fit.extent.AtGSensitivity() + 3 * c, 3);
    const WaldTest test = TestColumns(fit.solution, fit.state.g_sensitivity.row(c).transpose(),
                                      columns, TurnFreedom(fit) - 9.0);
    if (!(test.p_value < kSeen)) continue;
    HoldFinding finding = FindingOf(GSensitivityEffect().id, c, test);
    finding.in_model = true;
    finding.says =
        fmt::format("g-sensitivity seen on {}: {:.3g} deg/s/g at most, along {}", finding.channels,
                    kDegPerRad * test.values[Largest(test)], "xyz"[Largest(test)]);
    out.push_back(finding);
  }
  return out;
}

std::vector<HoldFinding> WhatIsLeft(const HeldChain& chain, const HoldFit& fit,
                                    const RestNoise& rests, double latitude_rad) {
  std::vector<HoldFinding> out;
  AddBentGyro(chain, fit, latitude_rad, &out);
  AddBentAccel(chain, fit, latitude_rad, &out);
  AddTurnNoise(fit, rests, &out);
  AddPoseScatter(chain, fit, &out);
  return out;
}

namespace {

// Of the gyro's output by what it should be: what no unit of its columns makes of it.
std::string CauseOfGyro(double factor, const MeasurementInfo& info) {
  const bool times = IsNearFactor(factor, 1000.0) || IsNearFactor(factor, 0.001);
  const char* const in_ms = "the times are in ms: t_s is in seconds";
  if (const auto unit = OtherUnitOfGyro(1.0 / factor, std::nullopt, info))
    return times ? fmt::format("{}; or {}", *unit, in_ms) : *unit;
  if (times) return in_ms;
  if (IsNearFactor(factor, 0.5))
    return "the sensor's range is twice the one that gyro_lsb_per_deg_s belongs to";
  if (IsNearFactor(factor, 2.0))
    return "the sensor's range is half of the one that gyro_lsb_per_deg_s belongs to";
  return "its unit, its sensitivity (gyro_lsb_per_deg_s) or the times are not what the table says";
}

std::string CauseOfAccelerometer(double factor) {
  const auto unit = OtherUnitOfAccelerometer(factor);
  return unit ? "the unit: " + *unit
              : "its unit is not g = 9.80665 m/s^2, as the columns' names say";
}

// Geometric mean of what the axes put out by what they should.
double GainOf(const Eigen::Matrix3d& m) {
  return std::cbrt(m.row(0).norm() * m.row(1).norm() * m.row(2).norm());
}

std::string CannotBe(const char* sensor, double factor, const std::string& cause) {
  return fmt::format(
      "this result cannot be: the {} puts out {:.4g} times what it should, at most {:g} % off was "
      "expected of any part. Most likely {}",
      sensor, factor, 100.0 * kLargestScaleError, cause);
}

bool CanBe(double factor) { return std::fabs(factor - 1.0) <= kLargestScaleError; }

}  // namespace

std::vector<std::string> ImplausibleHold(const HoldState& state, const MeasurementInfo& info) {
  std::vector<std::string> out;
  const double gyro = GainOf(state.m), accelerometer = GainOf(state.accel.Matrix());
  const bool sensitivity_given = std::isfinite(NominalUnitsPerDegPerS(info));
  if (sensitivity_given && !CanBe(gyro))
    out.push_back(CannotBe("gyro", gyro, CauseOfGyro(gyro, info)));
  if (!CanBe(accelerometer))
    out.push_back(CannotBe("accelerometer", accelerometer, CauseOfAccelerometer(accelerometer)));
  return out;
}

}  // namespace gyrobench::calibration
