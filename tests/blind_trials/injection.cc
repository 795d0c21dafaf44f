#include "tests/blind_trials/injection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace gyrobench::blind_trials {
namespace {

constexpr std::size_t kZ = 2, kInnerAxis = 2;
constexpr std::size_t kRowZ = 6;  // of a 3 x 3 matrix

double LogUniform(Random& random, double low, double high) {
  return std::exp(Uniform(random, std::log(low), std::log(high)));
}
double Sign(Random& random) { return random() % 2 == 0 ? 1.0 : -1.0; }

// Evenly over the sphere.
std::array<double, 3> Direction(Random& random) {
  std::normal_distribution<double> normal;
  std::array<double, 3> v = {normal(random), normal(random), normal(random)};
  const double length = std::hypot(v[0], v[1], v[2]);
  for (double& x : v) x /= length;
  return v;
}

void AddVector(Bench& bench, config::Square& key, double level, const char* letter,
               Random& random) {
  const std::array<double, 3> direction = Direction(random);
  for (std::size_t i = 0; i < 3; ++i) {
    key[kRowZ + i] += level * direction[i];
    bench.truth.push_back({{fmt::format("{}_{}", letter, "xyz"[i])}, level * direction[i]});
  }
}
void AddScalar(Bench& bench, config::Triple& key, double value, const char* name) {
  key[kZ] += value;
  bench.truth.push_back({{name}, value});
}
config::GyroScenario& Gyro(Bench& bench) { return bench.specimen.gyro; }
config::EncoderScenario& Encoder(Bench& bench) { return bench.specimen.encoder[kInnerAxis]; }
config::MechanicsScenario& Mechanics(Bench& bench) { return bench.specimen.mechanics[kInnerAxis]; }
void AddAmplitude(Bench& bench, double value) {
  bench.truth.push_back({{"amplitude"}, value, true});
}

void GLinear(Bench& bench, double level, Random& random) {
  AddVector(bench, Gyro(bench).g_linear_deg_s_per_g, level, "k", random);
}
void GSquared(Bench& bench, double level, Random& random) {
  const double angle = Uniform(random, 0.0, 2.0 * std::numbers::pi);
  const std::array<double, 2> k = {level * std::cos(angle), level * std::sin(angle)};
  for (std::size_t i = 0; i < 2; ++i) {
    Gyro(bench).g_squared_deg_s_per_g2[kRowZ + i] += k[i];
    bench.truth.push_back({{fmt::format("k_{}", "xy"[i])}, k[i]});
  }
}
void ScaleG(Bench& bench, double level, Random& random) {
  AddVector(bench, Gyro(bench).scale_g_per_g, 1e-2 * level, "c", random);
}
void ScaleTemperature(Bench& bench, double level, Random& random) {
  AddScalar(bench, Gyro(bench).scale_temperature_per_degC, 1e-2 * level * Sign(random), "c");
}
void Asymmetry(Bench& bench, double level, Random& random) {
  AddScalar(bench, Gyro(bench).asymmetry_rel, 1e-2 * level * Sign(random), "c");
}
void QuadraticOdd(Bench& bench, double level, Random& random) {
  AddScalar(bench, Gyro(bench).quadratic_odd_per_deg_s, 1e-2 * level / 40.0 * Sign(random), "c");
}
void Cubic(Bench& bench, double level, Random& random) {
  AddScalar(bench, Gyro(bench).cubic_per_deg2_s2, 1e-2 * level / 1600.0 * Sign(random), "c");
}
void TemperatureRate(Bench& bench, double level, Random& random) {
  AddScalar(bench, Gyro(bench).temperature_rate_deg_s_per_degC_s, level * Sign(random), "c");
}
void Hysteresis(Bench& bench, double level, Random& random) {
  Gyro(bench).hysteresis_play_degC = Uniform(random, 1.5, 3.0);
  AddScalar(bench, Gyro(bench).hysteresis_deg_s_per_degC, level * Sign(random), "c");
}
void WarmUp(Bench& bench, double level, Random& random) {
  Gyro(bench).warm_up_time_constant_s = LogUniform(random, 12.0, 90.0);
  AddScalar(bench, Gyro(bench).warm_up_deg_s, level * Sign(random), "A");
}
// The steps shake the stand at one of its speeds.
void Vibration(Bench& bench, double level, Random& random) {
  constexpr std::array<double, 5> kSpeeds_deg_s = {5, 8, 12, 18, 25};
  constexpr double kVibration_g = 0.1;
  auto& axis = Mechanics(bench);
  axis.resonance_width_deg_s = Uniform(random, 1.5, 3.0);
  axis.resonance_deg_s = kSpeeds_deg_s[random() % kSpeeds_deg_s.size()] +
                         Uniform(random, -0.5, 0.5) * axis.resonance_width_deg_s;
  axis.resonance_vibration_g = kVibration_g;
  const double a = level * Sign(random);
  Gyro(bench).vibration_deg_s_per_g2[kZ] = a / (kVibration_g * kVibration_g);
  bench.truth.push_back({{"A"}, a});
}
// Of the reference behind the gyro, or of the gyro's filter behind the reference.
void Latency(Bench& bench, double level, Random& random) {
  const double tau_s = 1e-3 * level;
  if (Sign(random) > 0) {
    for (auto& encoder : bench.specimen.encoder) encoder.latency_s += tau_s;
  } else {
    constexpr double kFilterDelay_s = 0.00098;
    Gyro(bench).filter_delay_rel += tau_s / kFilterDelay_s;
  }
  bench.truth.push_back({{"tau"}, tau_s, true});
}
void ClockDrift(Bench& bench, double level, Random& random) {
  const double eps = 1e-6 * level;
  if (Sign(random) > 0) {
    for (auto& encoder : bench.specimen.encoder) encoder.clock_drift_rel += eps;
  } else {
    bench.options.gyro_clock_rel += eps;
  }
  bench.truth.push_back({{"eps"}, level, true});
}
// The worm turns the table unevenly and the sensor sits on the shaft; or the sensor's own error.
void WormPeriod(Bench& bench, double level, Random& random) {
  const double phase_deg = Uniform(random, 0.0, 360.0);
  // A coupling's play needs the sensor at the table.
  if (Sign(random) > 0 && Encoder(bench).backlash_deg == 0.0) {
    Encoder(bench).side = config::EncoderScenario::Side::kShaft;
    Mechanics(bench).worm_1_deg = level;
    Mechanics(bench).worm_1_phase_deg = phase_deg;
  } else {
    Encoder(bench).worm_1_deg = level;
    Encoder(bench).worm_1_phase_deg = phase_deg;
  }
  AddAmplitude(bench, level);
}
void Eccentricity1(Bench& bench, double level, Random& random) {
  Encoder(bench).eccentricity_1_deg = level;
  Encoder(bench).eccentricity_1_phase_deg = Uniform(random, 0.0, 360.0);
  AddAmplitude(bench, level);
}
void Eccentricity2(Bench& bench, double level, Random& random) {
  Encoder(bench).eccentricity_2_deg = level;
  Encoder(bench).eccentricity_2_phase_deg = Uniform(random, 0.0, 360.0);
  AddAmplitude(bench, level);
}
// In the gear with the sensor on the shaft, or in the sensor's coupling: opposite signs.
void Backlash(Bench& bench, double level, Random& random) {
  const bool on_shaft = Encoder(bench).side == config::EncoderScenario::Side::kShaft;
  if (Sign(random) > 0 || on_shaft) {
    Encoder(bench).side = config::EncoderScenario::Side::kShaft;
    Mechanics(bench).backlash_deg = level;
  } else {
    Encoder(bench).backlash_deg = level;
  }
  bench.truth.push_back({{"b"}, level, true});
}
double SomeTime(Bench& bench, Random& random) {
  return bench.duration_s * Uniform(random, 0.1, 0.9);
}
void BiasStep(Bench& bench, double level, Random& random) {
  const double b = level * Sign(random);
  Gyro(bench).bias_steps.push_back({.at_s = SomeTime(bench, random), .deg_s = {0, 0, b}});
  bench.truth.push_back({{"b"}, b});
}
void Tone(Bench& bench, double level, Random& random) {
  Gyro(bench).tones.push_back({.frequency_hz = LogUniform(random, 0.1, 1.0),
                               .phase_deg = Uniform(random, 0.0, 360.0),
                               .deg_s = {0, 0, level}});
  AddAmplitude(bench, level);
}
void Ripple(Bench& bench, double level, Random& random) {
  Encoder(bench).ripple_deg = level;
  Encoder(bench).ripple_per_turn = static_cast<double>(5 + random() % 30);
  Encoder(bench).ripple_phase_deg = Uniform(random, 0.0, 360.0);
  AddAmplitude(bench, level);
}
void AngleStep(Bench& bench, double level, Random& random) {
  Encoder(bench).step_at_s = SomeTime(bench, random);
  Encoder(bench).step_deg = level * Sign(random);
  bench.truth.push_back({{"b"}, level, true});
}

// In no catalogue.

void GTemperature(Bench& bench, double level, Random& random) {
  const std::array<double, 3> direction = Direction(random);
  for (std::size_t i = 0; i < 3; ++i) {
    Gyro(bench).g_linear_deg_s_per_g_per_degC[kRowZ + i] += level * direction[i];
  }
}
void BiasJump(Bench& bench, double level, Random& random) {
  Gyro(bench).bias_jump_at_degC = Uniform(random, 25.0, 36.0);
  Gyro(bench).bias_jump_deg_s[kZ] = level * Sign(random);
}
void AddExtra(Bench& bench, std::function<double(const SampleTruth&)> extra) {
  bench.options.extra_z_deg_s = std::move(extra);
}
// A bias that grows with temperature, but not between two temperatures.
void FlatStretch(Bench& bench, double level, Random& random) {
  const double slope = level * Sign(random);
  const double from_degC = Uniform(random, 27.0, 31.0);
  const double to_degC = from_degC + Uniform(random, 3.0, 5.0);
  AddExtra(bench, [=](const SampleTruth& truth) {
    const double T = truth.die_degC;
    return slope * (T - std::clamp(T, from_degC, to_degC));
  });
}
void SlowTone(Bench& bench, double level, Random& random) {
  Gyro(bench).tones.push_back({.frequency_hz = 1.0 / Uniform(random, 100.0, 300.0),
                               .phase_deg = Uniform(random, 0.0, 360.0),
                               .deg_s = {0, 0, level}});
}
double SupplyOff(const SampleTruth& truth) { return truth.supply_v - 5.0; }

void SupplyBias(Bench& bench, double level, Random& random) {
  bench.options.supply = true;
  const double c = level * Sign(random);
  AddExtra(bench, [c](const SampleTruth& truth) { return c * SupplyOff(truth); });
}
void SupplyScale(Bench& bench, double level, Random& random) {
  bench.options.supply = true;
  const double c = level * Sign(random);
  AddExtra(bench,
           [c](const SampleTruth& truth) { return c * SupplyOff(truth) * truth.rate_z_deg_s; });
}
void SupplyGravity(Bench& bench, double level, Random& random) {
  bench.options.supply = true;
  const double c = level * Sign(random);
  AddExtra(bench, [c](const SampleTruth& truth) { return c * SupplyOff(truth) * truth.g[1]; });
}
void SupplyTemperature(Bench& bench, double level, Random& random) {
  bench.options.supply = true;
  const double c = level * Sign(random);
  AddExtra(bench, [c](const SampleTruth& truth) {
    return c * SupplyOff(truth) * (truth.die_degC - 30.0);
  });
}
void GravityProduct(Bench& bench, double level, Random& random) {
  const double c = level * Sign(random);
  AddExtra(bench, [c](const SampleTruth& truth) { return c * truth.g[0] * truth.g[1]; });
}

Injection Known(std::string id, std::string unit, std::array<double, 3> levels,
                void (*apply)(Bench&, double, Random&)) {
  return {id, std::move(unit), levels, {id}, true, apply};
}
Injection Unknown(std::string id, std::string unit, std::array<double, 3> levels,
                  std::vector<std::string> right_ids, void (*apply)(Bench&, double, Random&)) {
  return {std::move(id), std::move(unit), levels, std::move(right_ids), false, apply};
}

}  // namespace

const std::vector<Injection>& CatalogueInjections() {
  static const std::vector<Injection> all = {
      Known("bias.g_linear", "deg/s/g", {0.002, 0.01, 0.05}, GLinear),
      Known("bias.g_squared", "deg/s/g^2", {0.003, 0.01, 0.05}, GSquared),
      Known("scale.temperature", "%/degC", {0.003, 0.01, 0.03}, ScaleTemperature),
      Known("scale.asymmetry", "%", {0.005, 0.02, 0.1}, Asymmetry),
      Known("scale.quadratic_odd", "% at 40 deg/s", {0.01, 0.05, 0.2}, QuadraticOdd),
      Known("scale.cubic", "% at 40 deg/s", {0.01, 0.05, 0.2}, Cubic),
      Known("bias.temperature_rate", "deg/s/(degC/s)", {0.1, 0.3, 1}, TemperatureRate),
      Known("bias.hysteresis", "deg/s/degC", {0.003, 0.01, 0.03}, Hysteresis),
      Known("bias.warm_up", "deg/s", {0.03, 0.1, 0.3}, WarmUp),
      Known("angle.latency", "ms", {0.1, 0.5, 3}, Latency),
      Known("angle.clock_drift", "ms/1000 s", {0.05, 0.2, 1}, ClockDrift),
      Known("angle.worm_period", "deg", {0.0005, 0.002, 0.01}, WormPeriod),
      Known("angle.eccentricity_1", "deg", {0.003, 0.01, 0.03}, Eccentricity1),
      Known("angle.eccentricity_2", "deg", {0.001, 0.003, 0.01}, Eccentricity2),
      Known("angle.backlash", "deg", {0.001, 0.004, 0.02}, Backlash),
      Known("bias.vibration", "deg/s", {0.002, 0.01, 0.05}, Vibration),
      Known("scale.g", "%/g", {0.005, 0.02, 0.1}, ScaleG),
      Known("bias.step", "deg/s", {0.004, 0.015, 0.06}, BiasStep),
      Known("bias.tone", "deg/s", {0.0007, 0.003, 0.015}, Tone),
      Known("angle.ripple", "deg", {0.0005, 0.002, 0.01}, Ripple),
      Known("angle.step", "deg", {0.02, 0.08, 0.3}, AngleStep),
  };
  return all;
}

const std::vector<Injection>& UnknownInjections() {
  static const std::vector<Injection> all = {
      Unknown("g_temperature", "deg/s/g/degC", {0.0003, 0.001, 0.003}, {}, GTemperature),
      Unknown("bias_jump", "deg/s", {0.012, 0.036, 0.12}, {}, BiasJump),
      Unknown("flat_stretch", "deg/s/degC", {0.01, 0.03, 0.1}, {}, FlatStretch),
      Unknown("slow_tone", "deg/s", {0.003, 0.01, 0.03}, {"bias.tone"}, SlowTone),
      Unknown("supply_bias", "deg/s/V", {0.02, 0.06, 0.2}, {"bias.of(supply_v)"}, SupplyBias),
      Unknown("supply_scale", "1/V", {0.001, 0.003, 0.01}, {"scale.of(supply_v)"}, SupplyScale),
      Unknown("supply_gravity", "deg/s/V/g", {0.03, 0.1, 0.3}, {}, SupplyGravity),
      Unknown("supply_temperature", "deg/s/V/degC", {0.004, 0.012, 0.04}, {}, SupplyTemperature),
      Unknown("gravity_product", "deg/s/g^2", {0.01, 0.03, 0.1}, {}, GravityProduct),
  };
  return all;
}

const Injection& FindInjection(const std::string& id) {
  for (const auto* list : {&CatalogueInjections(), &UnknownInjections()}) {
    const auto found = std::ranges::find(*list, id, &Injection::id);
    if (found != list->end()) return *found;
  }
  throw DataError(fmt::format("no effect '{}' to inject: see blind_trials --list", id));
}

}  // namespace gyrobench::blind_trials
