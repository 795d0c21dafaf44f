// An effect is data: what it is called, what it does, what it depends on, what excites it.
//
//   xi / s0 = M w + b(T) + sum of rate effects + noise       [deg/s]
//   angle:  int xi / s0 dt = ... + sum of angle effects      [deg]
// Every effect is linear in its terms for given non-linear parameters:
//   effect(t) = sum_j c_j basis_j(state(t); nonlinear)
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibration/effects/effect_kind.h"
#include "calibration/state/track.h"

namespace gyrobench::calibration {

// What a basis is made for.
struct BasisContext {
  std::size_t channel = 2;      // SensorAxis of the output
  std::size_t table_axis = 2;   // StandAxis, for effects of one axis of the bench
  double gear_ratio = 40.0;     // shaft turns per table turn
  double reference_degC = 0.0;  // T0 of terms in T - T0
  std::size_t covariate = 0;    // index, for effects of a covariate
  double covariate_mean = 0.0;
  std::vector<double> nonlinear;  // in the order of Effect::nonlinear
  // Of each power-on: where in the play its first measurement begins, -0.5 .. 0.5; the middle where
  // nothing is said.
  std::vector<double> start_sides;
};

// The basis functions of one effect along time. Asked in the order of time; may remember.
class Basis {
 public:
  virtual ~Basis() = default;
  // Writes one value for each term of the effect: deg/s (of a rate) or deg (of an angle or an
  // integral) per unit of the term's coefficient.
  virtual void At(const TrackPoint& point, double* terms) = 0;
};

struct EffectTerm {
  std::string name;  // of the parameter
  std::string unit;
};

struct NonlinearParameter {
  std::string name;
  std::string unit;
  double low = 0.0, high = 0.0;
  std::vector<double> grid;  // start values
};

// Of the basis: a rate that the gyro shows; an angle of the reference or the bench; the integral
// over time of a rate that the gyro shows and that changes faster than nodes follow each other.
enum class EffectDomain { kRate, kAngle, kRateIntegral };

// What must be known of the measurement for an effect to be looked for.
enum Needs : unsigned {
  kNeedsNothing = 0,
  kNeedsRate = 1,  // motion about the channel's axis, by a reference
  kNeedsGravity = 2,
  kNeedsTemperature = 4,
  kNeedsTableAxis = 8,  // the angle of a table or of a single-axis reference
  kNeedsCovariate = 16,
  kNeedsVibration = 32,
};

struct Effect {
  std::string id;
  EffectDomain domain = EffectDomain::kRate;
  EffectOwner owner = EffectOwner::kGyro;
  std::string equation;
  std::string cause;
  std::string manoeuvre;  // that excites it
  unsigned needs = kNeedsNothing;
  std::vector<EffectTerm> terms;
  std::vector<NonlinearParameter> nonlinear;
  // The first non-linear parameter is the coefficient itself.
  bool tied = false;
  // Only positive coefficients make sense.
  bool positive = false;
  // What it must gain in -2 log L over an effect that does nearly the same, to be named before it.
  double handicap = 0.0;
  // Largest size that a part of the MPU-6050's class shows, in units of the terms.
  double typical_size = 0.0;
  // That is no experience but a constant of nature: no coefficient can be larger.
  bool limited = false;
  std::unique_ptr<Basis> (*basis)(const BasisContext& context) = nullptr;
};

// All effects that are looked for as terms, in the order of effects' documentation. Steps and tones
// are found by scans (trace/scans.h) and have their entries here as well.
const std::vector<Effect>& EffectCatalogue();
// An id may have several forms, told apart by their number of non-linear parameters. nullptr where
// there is none.
const Effect* FindEffect(const std::string& id, std::size_t nonlinear_parameters);

}  // namespace gyrobench::calibration
