// One blind trial: a part and its noise drawn from a seed, with or without something hidden in it,
// recorded.
//
//   calibration::Collector collector;
//   TrialTruth truth = RecordTrial({.seed = 7, .effects = {{"scale.cubic", kMid}}}, collector);
#pragma once

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "tests/blind_trials/injection.h"
#include "tests/blind_trials/sequence.h"

namespace gyrobench::blind_trials {

// Angle random walk of an ideal trial.
inline constexpr double kDither_deg_sqrt_s = 3e-4;

enum Level { kLow = 0, kMid = 1, kHigh = 2 };
inline constexpr std::array<const char*, 3> kLevelNames = {"low", "mid", "high"};

struct HiddenEffect {
  std::string id;
  Level level = kHigh;
};

enum class NoiseKind { kWhite, kHeavyTails, kFlicker };
inline constexpr std::array<const char*, 3> kNoiseNames = {"white", "heavy tails", "1/f"};

struct TrialSpec {
  // Of everything that is drawn. Any number: it says nothing of what is hidden.
  std::uint64_t seed = 1;
  // Another run of the same part through the same sequence: other noise.
  std::uint64_t run = 0;
  SequenceKind sequence = SequenceKind::kFull;
  std::vector<HiddenEffect> effects = {};
  bool all_channels = false;  // otherwise z alone; effects are on z
  // Standard deviation of the part's sensitivities to gravity, drawn for all channels.
  double g_linear_deg_s_per_g = 0.0;
  double reference_rate_hz = 10.0;
  bool latitude_known = true;  // to the recording
  // R_mount = Rz Ry Rx: how the sensor sits on the table, and whether the recording says so.
  config::Triple mount_deg = {};
  bool mount_known = true;
  int repeats = 1;  // of the sequence
  // No error, and of noise only as much as the counts need in order not to add up at constant rate;
  // effects all the same.
  bool ideal = false;
  // Of the recording and of its power-on. It must say nothing of what is hidden.
  std::string name = "recording";
};

// The part that was drawn: its vector model, and its accelerometer's.
struct TruePart {
  config::Square m = {};                    // row by row
  config::Square g_linear = {};             // deg/s/g, row: output
  double reference_degC = 25.0;             // of the bias's polynomial
  std::array<config::Triple, 4> bias = {};  // deg/s/degC^k, of x, y, z
  config::Square accel_m = {};
  config::Triple accel_offset_g = {};
};

struct TrialTruth {
  struct Effect {
    std::string id;
    std::vector<TrueParameter> parameters;
  };
  std::vector<Effect> effects;
  TruePart part;
  NoiseKind noise = NoiseKind::kWhite;
  double angle_random_walk_deg_sqrt_s = 0.0;
  double bias_random_walk_deg_s_sqrt_s = 0.0;
  double reference_deg = 0.0;
  bool supply_recorded = false;
  double duration_s = 0.0;
};

// Of the part and of its noise.
struct PartSeeds {
  std::uint64_t part = 0, noise = 0;
};
PartSeeds DrawSeeds(const TrialSpec& spec, std::mt19937_64& random);

// A part with what is hidden in it: everything but the motion. Events take place before
// `duration_s`.
struct DrawnTrial {
  Bench bench;
  TrialTruth truth;
};
DrawnTrial DrawTrial(const TrialSpec& spec, const PartSeeds& seeds, double duration_s,
                     std::mt19937_64& random);

// The stand of every trial.
const config::StandConfig& TrialStand();

// Three of five trials have white noise and a random walk only, one has heavy tails, one 1/f noise.
TrialTruth RecordTrial(const TrialSpec& spec, MeasurementSink& sink);

}  // namespace gyrobench::blind_trials
