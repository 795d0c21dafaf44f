#include "tests/blind_trials/trial.h"

#include <cmath>
#include <filesystem>

#include "stand/bench_physics.h"
#include "stand/random.h"

namespace gyrobench::blind_trials {
namespace {

namespace fs = std::filesystem;

const config::StandConfig& Stand() {
  static const config::StandConfig stand =
      config::LoadStandConfig(fs::path(GYROBENCH_SOURCE_DIR) / "config/virtual.toml");
  return stand;
}

const config::Scenario& FullSequenceScenario() {
  static const config::Scenario scenario = [] {
    config::Scenario loaded = config::LoadScenario(fs::path(GYROBENCH_SOURCE_DIR) /
                                                   "config/scenarios/full-sequence.toml");
    // The recorder declares no delay: the reference is as late as the gyro behind its 256 Hz
    // filter.
    for (auto& encoder : loaded.encoder) encoder.latency_s = 0.00098;
    return loaded;
  }();
  return scenario;
}

void Multiply(config::Triple& values, double factor) {
  for (double& value : values) value *= factor;
}

NoiseKind DrawNoise(config::Scenario& scenario, Random& random) {
  config::GyroScenario& gyro = scenario.gyro;
  Multiply(gyro.angle_random_walk_deg_sqrt_s, Uniform(random, 0.8, 1.25));
  Multiply(gyro.bias_random_walk_deg_s_sqrt_s,
           std::exp(Uniform(random, std::log(0.5), std::log(3.0))));
  const double reference = Uniform(random, 0.7, 1.5);
  for (config::EncoderScenario& encoder : scenario.encoder) encoder.noise_deg *= reference;
  const auto lot = random() % 5;
  if (lot == 3) {
    gyro.heavy_tail_fraction = Uniform(random, 0.002, 0.01);
    gyro.heavy_tail_factor = Uniform(random, 5.0, 10.0);
    return NoiseKind::kHeavyTails;
  }
  if (lot == 4) {
    gyro.flicker_deg_s.fill(Uniform(random, 0.3e-3, 1.5e-3));
    return NoiseKind::kFlicker;
  }
  return NoiseKind::kWhite;
}

// Heavy tails count with their variance; 1/f noise has no place in these numbers.
void SetNoiseOf(const config::Scenario& scenario, TrialTruth& truth) {
  const config::GyroScenario& gyro = scenario.gyro;
  const double factor = gyro.heavy_tail_factor;
  const double tails = 1.0 + gyro.heavy_tail_fraction * (factor * factor - 1.0);
  truth.angle_random_walk_deg_sqrt_s = gyro.angle_random_walk_deg_sqrt_s[2] * std::sqrt(tails);
  truth.bias_random_walk_deg_s_sqrt_s = gyro.bias_random_walk_deg_s_sqrt_s[2];
  truth.reference_deg = scenario.encoder[2].noise_deg;
}

config::Scenario Noiseless() {
  config::Scenario scenario = config::IdealScenario();
  scenario.room = FullSequenceScenario().room;
  scenario.thermal = FullSequenceScenario().thermal;
  scenario.thermal.thermometer_noise_degC = 0.0;
  scenario.gyro.angle_random_walk_deg_sqrt_s.fill(kDither_deg_sqrt_s);
  for (auto& encoder : scenario.encoder) {
    encoder.latency_s = FullSequenceScenario().encoder[0].latency_s;
  }
  return scenario;
}

// Noise is drawn after the order of the full sequence, whichever is recorded: the part stays the
// same.
Sequence DrawSequence(const TrialSpec& spec, Random& random) {
  if (spec.sequence != SequenceKind::kElsewhere)
    return MakeSequence(spec.sequence, random, spec.repeats);
  Random own = random;
  MakeSequence(SequenceKind::kFull, random);
  return MakeSequence(spec.sequence, own, spec.repeats);
}

config::Square WithDiagonal(const config::Square& off, const config::Triple& scale_rel) {
  config::Square out = off;
  for (std::size_t i = 0; i < 3; ++i) out[4 * i] = 1.0 + scale_rel[i];
  return out;
}

TruePart PartOf(const config::Scenario& specimen) {
  const config::GyroScenario& gyro = specimen.gyro;
  const config::AccelerometerScenario& accel = specimen.accelerometer;
  return {.m = WithDiagonal(gyro.cross_axis_rel, gyro.scale_rel),
          .g_linear = gyro.g_linear_deg_s_per_g,
          .reference_degC = gyro.reference_degC,
          .bias = {gyro.bias_deg_s, gyro.bias_deg_s_per_degC, gyro.bias_deg_s_per_degC2,
                   gyro.bias_deg_s_per_degC3},
          .accel_m = WithDiagonal(accel.cross_axis_rel, accel.scale_rel),
          .accel_offset_g = accel.offset_g};
}

}  // namespace

const config::StandConfig& TrialStand() { return Stand(); }

PartSeeds DrawSeeds(const TrialSpec& spec, Random& random) {
  const std::uint64_t part = random(), noise = random() ^ stand::Mix(spec.run);
  return {part, noise};
}

DrawnTrial DrawTrial(const TrialSpec& spec, const PartSeeds& seeds, double duration_s,
                     Random& random) {
  DrawnTrial drawn;
  TrialTruth& truth = drawn.truth;
  truth.duration_s = duration_s;
  config::Scenario scenario = FullSequenceScenario();
  truth.noise = DrawNoise(scenario, random);
  SetNoiseOf(scenario, truth);
  // A column that has nothing to do with anything, now and then. Drawn in an ideal trial as well,
  // so that what is hidden is the same.
  const bool idle_column = random() % 5 == 0;
  if (spec.ideal) scenario = Noiseless();
  if (!spec.ideal) scenario.drawn.gyro_g_linear_deg_s_per_g = spec.g_linear_deg_s_per_g;
  Bench& bench = drawn.bench;
  bench.specimen = stand::DrawSpecimen(scenario, seeds.part);
  bench.specimen.site.mount_deg = spec.mount_deg;
  if (spec.mount_known) bench.options.geometry.mount_deg = spec.mount_deg;
  truth.part = PartOf(bench.specimen);
  bench.duration_s = duration_s;
  bench.options.source = spec.name;
  bench.options.channels = {spec.all_channels, spec.all_channels, true};
  bench.options.latitude_known = spec.latitude_known;
  bench.options.reference_rate_hz = spec.reference_rate_hz;
  bench.options.supply = idle_column && !spec.ideal;
  for (const HiddenEffect& effect : spec.effects) {
    const Injection& injection = FindInjection(effect.id);
    bench.truth.clear();
    injection.apply(bench, injection.levels[effect.level], random);
    truth.effects.push_back({effect.id, bench.truth});
  }
  truth.supply_recorded = bench.options.supply;
  return drawn;
}

TrialTruth RecordTrial(const TrialSpec& spec, MeasurementSink& sink) {
  Random random(stand::Mix(spec.seed));
  const PartSeeds seeds = DrawSeeds(spec, random);
  const Sequence sequence = DrawSequence(spec, random);
  const DrawnTrial drawn = DrawTrial(spec, seeds, sequence.duration_s, random);
  Record(Stand(), drawn.bench.specimen, sequence, seeds.noise, drawn.bench.options, sink);
  return drawn.truth;
}

}  // namespace gyrobench::blind_trials
