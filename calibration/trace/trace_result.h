// What a trace says: from the residual of a baseline fit to the effects that explain it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/effects/effect_kind.h"
#include "calibration/gls/noise_model.h"
#include "calibration/sensor/vector_calibration.h"

namespace gyrobench::calibration {

// none: nothing beyond the baseline is to be seen. explained: the effects named account for all
// that was to be seen. partly_explained: effects were named and structure remains. unexplained:
// structure remains and no effect could be named. cannot_be: gyro and reference contradict each
// other by more than any part does, or the data are no measurement of the gyro; whatever was fitted
// to them means nothing, and the summary says what is likeliest wrong (Condemn).
enum class Verdict { kNone, kExplained, kPartlyExplained, kUnexplained, kCannotBe };

const char* Name(Verdict verdict);

// A number of the model.
struct ModelParameter {
  std::string name;
  double value = kMissing;
  std::string unit;
  // With the reference's own uncertainty, where it is said, and with what an Earth's rotation that
  // is not taken off may be of a g-sensitivity.
  double std_error = kMissing;
  double bound = kMissing;  // standard error at the Cramer-Rao bound, under the noise as estimated
  // Without either; NaN where neither has a part in it.
  double statistical_std_error = kMissing;
  // Why there is neither a value nor an error: of a coefficient that these data do not determine,
  // and that the model holds at 0.
  std::optional<std::string> because = std::nullopt;
};

// A figure before and after the effects are added.
struct HeldOut {
  double before = kMissing, after = kMissing;
  // Of the reduction, 1 - after / before; block or run bootstrap.
  std::array<double, 2> reduction_ci95 = {kMissing, kMissing};

  // Both are known, and nothing got less: data that the choice never saw do not confirm it.
  bool confirms_nothing() const { return after >= before; }
};

struct TracedEffect {
  std::string id;
  EffectOrigin origin = EffectOrigin::kCatalogue;
  EffectOwner owner = EffectOwner::kGyro;
  std::string equation;
  std::string cause;
  std::vector<ModelParameter> parameters;  // linear ones, then non-linear ones
  double p_value = kMissing;               // after correction for everything that was tried
  std::vector<std::string> rivals;         // ids that these data cannot tell from it; may be empty
  std::string settled_by;                  // manoeuvre that would; empty when certain
  // Held out: the model without this effect, and with it.
  HeldOut heldout_whitened_rms;
  HeldOut heldout_angle_rms_deg;  // angle error in windows of 10 s, mean of each removed
  ChosenOn chosen_on = ChosenOn::kAllData;
};

// The effect's own angle error over the one that is left with it, held out: errors add in squares.
// 0 where the error is no larger without it, NaN where that was not tried.
double ShareOfError(const TracedEffect& effect);

struct Unidentifiable {
  std::string id;
  std::string because;
  std::string settled_by;  // the manoeuvre that would show it
  // The figures of `because` where the effect's size is the reason: its standard deviation in these
  // data, and the largest size that such parts show. Not part of the JSON.
  struct Limit {
    double bound = kMissing, largest = kMissing;
    std::string unit;
  };
  std::optional<Limit> limit = std::nullopt;
};

// What still speaks after the effects.
struct Finding {
  std::string test;       // whiteness, covariate, variance
  std::string covariate;  // empty where the test has none
  double p_value = kMissing;
  std::string says;
};

// A curve for the report: points in order of x. Not part of the JSON.
struct Series {
  std::vector<double> x, before, after;
};

// One point of the Allan deviation of the gyro at rest, and what the noise model says there.
struct AllanPoint {
  double tau_s = 0.0;
  double measured_deg_s = kMissing, std_error_deg_s = kMissing;
  double model_deg_s = kMissing;
};

// The residual of one channel, before (baseline alone) and after (with the effects), thinned for
// plotting. Angle errors in deg, mean of each 10 s window removed; rate errors in deg/s.
struct ResidualCurves {
  Series angle_error_by_time_s;           // deg
  Series rate_error_by_temperature_degC;  // deg/s, binned means
  Series rate_error_by_rate_deg_s;        // deg/s, binned means against the true rate
  Series angle_error_by_table_angle_deg;  // deg, binned means against the table angle
  Series rate_error_by_traced_covariate;  // deg/s, binned means; empty without one
  std::string traced_covariate;           // its name and unit
  Series whitened_spectrum_by_hz;         // power relative to white noise of unit variance
  std::vector<AllanPoint> allan;
};

struct ChannelTrace {
  SensorAxis axis = SensorAxis::kZ;
  Verdict verdict = Verdict::kNone;
  std::string summary;  // the verdict in one or two sentences
  struct Baseline {
    std::vector<ModelParameter> parameters;
    double reference_degC = kMissing;  // at which the zero-rate offset holds; NaN: any temperature
    double whitened_rms = kMissing;    // under the noise of the saturated model; 1 is the floor
    double angle_rms_deg = kMissing;
  } baseline;
  std::vector<TracedEffect> effects;
  // All effects together, baseline alone before, baseline and effects after: effects, noise and
  // coefficients chosen on two thirds of the data, tried on the rest, which nothing of it saw. NaN
  // where the data are too few to be divided.
  HeldOut heldout_whitened_rms;
  HeldOut heldout_angle_rms_deg;
  std::vector<std::string> training_effects;  // ids that these two thirds ask for
  // The same angle error, all chosen on the first 60 % of the time, tried on the rest: a forecast.
  HeldOut forecast_angle_rms_deg;
  // The model of all data, on the same data that it was chosen by and fitted to.
  HeldOut fitted_whitened_rms;
  HeldOut fitted_angle_rms_deg;
  std::vector<Unidentifiable> unidentifiable;
  struct Remaining {
    // Not white and without a finding: what a coarse encoder's rounding leaves.
    bool white = true;
    std::vector<Finding> findings;
  } remaining;
  NoiseModel noise;  // by restricted maximum likelihood
  ResidualCurves curves;
  std::vector<std::string> remarks;  // what could not be estimated, and why
};

// Where nothing was fitted, nothing was looked at: the verdict "none" is no verdict.
bool IsTraced(const ChannelTrace& channel);

struct TraceInput {
  std::string file;
  std::int64_t samples = 0;
  double duration_s = 0.0;
  std::vector<Defect> defects;
};

struct TraceResult {
  std::vector<TraceInput> inputs;
  std::vector<ChannelTrace> channels;
  std::vector<std::string> remarks;  // of the measurement as a whole
  VectorCalibration vector;          // the channels as one sensor
  // What the inputs say of the reference's own error, and what that means for these results; empty
  // where there is no reference.
  std::string reference_error;
  // Relative standard uncertainty of the reference in the scale factors, the largest of the axes.
  // NaN: nothing is said, and they are relative to the reference.
  double reference_uncertainty = kMissing;
};

// The verdict of these axes of the sensor becomes cannot_be, with `says` as its summary, which
// comes without its full stop; that of an axis which was not traced stays.
void Condemn(const std::array<bool, 3>& axes, const std::string& says, TraceResult* result);

}  // namespace gyrobench::calibration
