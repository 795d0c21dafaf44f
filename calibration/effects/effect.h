// An effect is data: what it is called, what it does, what it depends on, what excites it, how it
// is searched for. Each has a file of its own in calibration/effects/catalogue/.
//
//   xi / s0 = M w + b(T) + sum of rate effects + noise       [deg/s]
//   angle:  int xi / s0 dt = ... + sum of angle effects      [deg]
// Every effect is linear in its terms for given non-linear parameters:
//   effect(t) = sum_j c_j basis_j(state(t); nonlinear)
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "calibration/effects/effect_kind.h"
#include "calibration/state/sensor_state.h"

namespace gyrobench::calibration {

// By how much the gyro is late against the reference, by a coefficient and the time of the
// measurement [s].
using DelayFunction = double (*)(double coefficient, double t_s);
struct Delay {
  DelayFunction delay_s = nullptr;
  double coefficient = 0.0;
};
// Delays that add up to less than this leave each other's shape as it is: in a ramp of 60 deg/s^2
// the mean rate within it is another by 0.15 deg/s than at its begin.
inline constexpr double kLongDelay_s = 0.005;
inline double TotalDelay_s(const std::vector<Delay>& delays, double t_s) {
  double sum_s = 0.0;
  for (const Delay& delay : delays) sum_s += delay.delay_s(delay.coefficient, t_s);
  return sum_s;
}

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
  // Of an effect that shakes the stand: by the speed of each of the stand's axes, not by the rate
  // about the channel's.
  bool of_stand = false;
  // Of a delay: what else makes the gyro late. Delays add in time: each has the shape of all of
  // them together, the mean rate within their sum.
  std::vector<Delay> other_delays;
};

// The basis functions of one effect along time. Asked in the order of time; may remember.
class Basis {
 public:
  virtual ~Basis() = default;
  // Writes one value for each term of the effect: deg/s (of a rate) or deg (of an angle or an
  // integral) per unit of the term's coefficient.
  virtual void At(const SensorState& point, double* terms) = 0;
};

struct EffectTerm {
  std::string name;  // of the parameter
  std::string unit;
};

struct NonlinearParameter {
  std::string name;
  std::string unit;
  double low = 0.0, high = 0.0;   // equal where a scan or the grid alone says what is tried
  std::vector<double> grid = {};  // start values
};

// Of the basis: a rate that the gyro shows; an angle of the reference or the bench; the integral
// over time of a rate that the gyro shows and that changes faster than nodes follow each other.
enum class EffectDomain { kRate, kAngle, kRateIntegral };

// How the values of the non-linear parameters are found.
enum class Search {
  kNone,         // there are none
  kCoefficient,  // the first is the coefficient itself
  kGrid,         // from the best point of their grids on
  kEachPoint,    // each point of the grid is an effect of its own
  kTime,         // a scan over all times
  kFrequency,    // a scan over all frequencies
  kPeriods,      // a scan over all numbers of periods in a turn of the table
};

// What must be known of the measurement for an effect to be looked for.
enum Needs : unsigned {
  kNeedsNothing = 0,
  kNeedsRate = 1,  // motion about the channel's axis, by a reference
  kNeedsGravity = 2,
  kNeedsTemperature = 4,
  kNeedsTableAxis = 8,  // the angle of a table or of a single-axis reference
  kNeedsCovariate = 16,
  kNeedsVibration = 32,
  kNeedsPowerOn = 64,  // when the sensor was switched on
  kNeedsGear = 128,    // the gear between shaft and table
};

// Of the measurements that an effect is looked for in.
struct DataRange {
  double max_rate_deg_s = 0.0;
  double temperature_degC = 0.0;   // from the lowest to the highest
  std::vector<bool> turns_in_run;  // about the channel's axis; by its place
};

struct Effect {
  std::string id;
  EffectDomain domain = EffectDomain::kRate;
  EffectOwner owner = EffectOwner::kGyro;
  std::string equation = {};
  std::string cause = {};
  std::string looks_like = {};  // in the residual of the baseline
  std::string manoeuvre = {};   // that excites it; {}: the column (ManoeuvreFor)
  unsigned needs = kNeedsNothing;
  std::vector<EffectTerm> terms = {};
  std::vector<NonlinearParameter> nonlinear = {};
  Search search = Search::kNone;
  // Largest size that a part of the MPU-6050's class shows, in units of the terms; 0: not known.
  double typical_size = 0.0;
  std::string size_source = {};
  // Coefficients of so many typical sizes are taken for those of something else.
  static constexpr double kImplausible = 10.0;
  // The typical size may be exceeded by far, as by a slip.
  bool may_be_larger = false;
  // The largest size is a constant of nature: no coefficient can be larger.
  bool limited = false;
  // Only positive coefficients make sense.
  bool positive = false;
  // What it must gain in -2 log L over an effect that does nearly the same, to be named before it.
  double complexity_penalty = 0.0;
  // Relative error of its regressor: motion, filter and reference are known to a hundredth. Beside it
  // another effect is named only for more than the square of that of what it explains itself.
  static constexpr double kShapeError = 0.01;
  double shape_error = kShapeError;
  // Changes slowly enough for a curve of the temperature or the time to describe it as well.
  bool slow = false;
  // A shape of the gyro's filter: where that is free in the baseline, all such effects are one.
  bool filter_shape = false;
  // Of an effect that is a delay, whose coefficient this takes; nullptr: it is none.
  DelayFunction delay_s = nullptr;
  // It grows with the time, as the clocks part.
  bool delay_of_clocks = false;
  // What the rounding of a coarse encoder makes of it, of half a step of the encoder; 0: nothing.
  double made_by_rounding = 0.0;
  // Goes by the speed at which the stand is shaken, which any of its axes may do.
  bool shakes_stand = false;
  // True motion of the sensor, not an error of it.
  bool true_motion = false;
  // The reference reads the table's axis wrong by a wave of its angle with known periods, of which no
  // part is constant.
  bool wave_of_angle = false;
  // An angle, or the integral of a rate, without a memory, of the time and the table's angle alone,
  // that changes within the time which the readings of a node take (trace/within_nodes.h).
  bool of_each_reading = false;
  // What a certificate bounds as the reference's eccentricity.
  bool reference_eccentricity = false;
  // Id of the effect whose size differs in one of several runs; empty for all others. Nothing that
  // is done within a run shows it.
  std::string differs_in_one_run = {};
  // Remembers, and how each power-on begins is not known: BasisContext::start_sides.
  bool unknown_start = false;
  // The correction in C, in deg/s, for export: {c0}, {c1} ... the coefficients, {minus_1_over_n0}
  // -1 over the non-linear parameter, {w} the rate, {t} the temperature, {t0} T0; g[],
  // in->temperature_rate_degC_s and in->since_power_on_s are the function's inputs. Empty: not a
  // function of these.
  std::string c_expression = {};
  // Whether these non-linear parameters make sense in such data; nullptr: they always do.
  bool (*makes_sense)(const DataRange& data, const std::vector<double>& nonlinear) = nullptr;
  std::unique_ptr<Basis> (*basis)(const BasisContext& context) = nullptr;

  // Beyond it a coefficient is none of this effect's [unit of the terms]; infinite: it may be any.
  double implausible_size() const {
    return typical_size > 0.0 && !may_be_larger ? kImplausible * typical_size
                                                : std::numeric_limits<double>::infinity();
  }
  bool of_one_run() const { return !differs_in_one_run.empty(); }
  // Delays, and what they are more in one run.
  bool of_delay() const { return delay_s != nullptr || of_one_run(); }
  // It happens at one time or has one phase, which no other measurement shares.
  bool of_one_time() const { return search == Search::kTime || search == Search::kFrequency; }
};

// All effects that are looked for as terms, in the order in which `gyrobench effects` lists them.
// Steps and tones are found by scans (trace/scans.h) and have their entries here as well.
const std::vector<Effect>& EffectCatalogue();
// An id may have several forms, told apart by their number of non-linear parameters. nullptr where
// there is none.
const Effect* FindEffect(const std::string& id, std::size_t nonlinear_parameters);
// Its first form.
const Effect* FindEffect(const std::string& id);
// What excites it; of an effect of a column with the name of that.
std::string ManoeuvreFor(const Effect& effect, const std::string& column = "the column");
// The same of "bias.of(supply_v)" and other ids; empty where the catalogue does not have it.
std::string ManoeuvreOf(const std::string& id);
// Of an id of a trace: "bias.of" of "bias.of(supply_v)".
std::string CatalogueName(const std::string& id);

// Those that other rooms must speak of by themselves.
const Effect& GSensitivityEffect();
const Effect& EarthRotationEffect();
// That of a scan.
const Effect& ScannedEffect(Search search, EffectDomain domain);

// What no measurement with one reference and one clock can show.
struct NeverSeen {
  std::string id, because, settled_by;
  bool seen_by_host_clock = false;  // pairs of both clocks show it
};
const std::vector<NeverSeen>& NeverSeenEffects();

}  // namespace gyrobench::calibration
