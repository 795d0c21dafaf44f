#include "stand/angle_encoder.h"

#include <algorithm>
#include <cmath>

#include "base/geometry.h"
#include "stand/random.h"

namespace gyrobench::stand {
namespace {

double Wave(double amplitude, double harmonic, double angle_deg, double phase_deg) {
  if (amplitude == 0.0) return 0.0;
  return amplitude * std::sin((harmonic * angle_deg + phase_deg) * kRadPerDeg);
}

}  // namespace

AngleEncoder::AngleEncoder(const config::EncoderScenario& scenario,
                           const config::EncoderConfig& config, double gear_ratio,
                           std::uint64_t source_seed)
    : scenario_(scenario),
      sign_(config.sign),
      offset_deg_(config.offset_deg),
      counts_per_deg_(config.map.counts_per_turn / 360.0),
      range_counts_(static_cast<std::int64_t>(config.map.range_counts)),
      gear_ratio_(gear_ratio),
      source_seed_(source_seed) {}

double AngleEncoder::Reading_deg(double t_s, const AxisMechanics& axis) const {
  const auto& s = scenario_;
  const double tick = std::floor(t_s / s.refresh_s);
  const double fresh_s = tick * s.refresh_s;
  const double taken_s = std::min(fresh_s, fresh_s * (1.0 - s.clock_drift_rel) - s.latency_s);
  const AxisTruth truth = axis.At(taken_s);
  const double phi =
      s.side == config::EncoderScenario::Side::kTable ? truth.coupled_deg : truth.shaft_deg;
  const double psi = truth.shaft_deg * gear_ratio_;
  double reading = phi * (1.0 + s.scale_rel) + s.zero_deg;
  reading += Wave(s.eccentricity_1_deg, 1.0, phi, s.eccentricity_1_phase_deg);
  reading += Wave(s.eccentricity_2_deg, 2.0, phi, s.eccentricity_2_phase_deg);
  reading += Wave(s.ripple_deg, s.ripple_per_turn, phi, s.ripple_phase_deg);
  reading += Wave(s.worm_1_deg, 1.0, psi, s.worm_1_phase_deg);
  reading += Wave(s.worm_2_deg, 2.0, psi, s.worm_2_phase_deg);
  if (s.step_deg != 0.0 && taken_s >= s.step_at_s) reading += s.step_deg;
  if (s.noise_deg != 0.0) {
    reading += s.noise_deg * NormalAt(source_seed_, static_cast<std::uint64_t>(tick));
  }
  return reading;
}

std::uint32_t AngleEncoder::Counts(double t_s, const AxisMechanics& axis, double jump_deg) const {
  const double exact = sign_ * (Reading_deg(t_s, axis) + jump_deg - offset_deg_) * counts_per_deg_;
  const std::int64_t counts = static_cast<std::int64_t>(std::floor(exact + 0.5)) % range_counts_;
  return static_cast<std::uint32_t>(counts < 0 ? counts + range_counts_ : counts);
}

}  // namespace gyrobench::stand
