#include "calibration/estimators/scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/estimators/paper.h"
#include "calibration/estimators/part_ways.h"
#include "calibration/estimators/scale_problem.h"
#include "calibration/gls/noise_fit.h"
#include "calibration/gls/statistics.h"
#include "calibration/signal/output_unit.h"
#include "calibration/signal/reference_error.h"

namespace gyrobench::calibration {
namespace {

// Fewer turns than this beyond the parameters say too little of the reference's error.
constexpr int kTurnsForReference = 5;
constexpr double kNotWhite = 1e-3;
constexpr std::size_t kWhitenessLags = 10;
constexpr std::size_t kMaxBiasOrder = 2;
// Other axes' rotation that cannot be told from this axis's: beyond this growth of the variance.
constexpr double kInseparable = 100.0;
// MPU-6050 data sheet: cross-axis sensitivity within ±2 %, taken as uniform. What it may make more
// of than the scale factor's own tolerance is no result.
constexpr double kMostCrossAxis = 0.02;
// Standard errors that grow by less are not worth a remark.
constexpr double kWorthSaying = 1.05;
// Standard deviation of what is uniform within ±1.
const double kUniform = 1.0 / std::sqrt(3.0);

// Residual of the moving intervals, and their rates.
void DescribeMotion(const std::vector<Row>& rows, std::size_t channel, double units,
                    double bias_units, double floor_deg, ScaleResult* result) {
  double square = 0.0;
  std::int64_t moving = 0;
  for (const Row& row : rows) {
    if (row.still || !row.usable[channel]) continue;
    const double turned = row.rotation_deg[channel] + row.earth_deg[channel];
    const double measured = (row.z[channel] - bias_units * row.duration_s()) / units;
    square += (measured - turned) * (measured - turned);
    ++moving;
    if (std::fabs(turned) < floor_deg) continue;
    const double rate = turned / row.duration_s();
    result->min_rate_deg_s = std::fmin(result->min_rate_deg_s, rate);
    result->max_rate_deg_s = std::fmax(result->max_rate_deg_s, rate);
  }
  if (moving > 0) result->residual_rms_deg = std::sqrt(square / static_cast<double>(moving));
}

double WhitenedRms(const IntervalSeries& series, const FitOptions& options, NoiseModel noise,
                   double most_reference_deg) {
  noise.reference_deg = std::fmin(noise.reference_deg, most_reference_deg);
  const GlsSolution solution = Solve(Whiten(series, noise), options.regressors, options.output);
  const double freedom =
      static_cast<double>(series.rows()) - static_cast<double>(options.regressors.size());
  return solution.solvable && freedom > 0 ? std::sqrt(solution.residual_square / freedom)
                                          : kMissing;
}

class ChannelScale {
 public:
  ChannelScale(const Estimation& estimation, std::size_t channel)
      : estimation_(estimation), info_(estimation.info), channel_(channel) {}

  // False, with a reason, when nothing can be said.
  bool Run(ScaleResult* result, std::string* reason);
  // What the axis turned while the output did not follow; 0 where it did.
  double unfollowed_deg() const { return unfollowed_deg_; }
  const std::vector<Defect>& defects() const { return defects_; }

 private:
  void LeaveOutWhatDisagrees(ScaleResult* result);
  void ChooseColumns();
  double UnseenReference(std::int64_t count, const std::string& what, ScaleResult* result) const;
  void ChooseReference(FitOptions* options, ScaleResult* result);
  bool Separable(const IntervalSeries& series) const;
  bool TakeTogether(const IntervalSeries& series, ScaleResult* result, std::string* reason);
  bool SetUp(ScaleResult* result, std::string* reason, IntervalSeries* series);
  double AllowForStructure(const GlsFit& fit, const FitOptions& options,
                           const IntervalSeries& series, double variance,
                           ScaleResult* result) const;
  void Report(const GlsFit& fit, const FitOptions& options, const IntervalSeries& series,
              ScaleResult* result);
  void AllowForGravity(const GlsFit& fit, const FitOptions& options, double variance,
                       ScaleResult* result);
  double AddReference(ScaleResult* result) const;
  double MostReference(ScaleResult* result) const;
  void ReportPaper(ScaleResult* result) const;

  const Estimation& estimation_;
  const MeasurementInfo& info_;
  std::size_t channel_;
  ScalePlan plan_;
  std::vector<Vector3> gravity_g_s_;  // of the plan's rows; empty where it is not known
  ScaleProblem problem_;
  double gain_ = kMissing;
  // Of the scale factor, relative: what the fit does not know of.
  double more_variance_ = 0.0;
  double unfollowed_deg_ = 0.0;
  std::vector<Defect> defects_;
};

void ChannelScale::LeaveOutWhatDisagrees(ScaleResult* result) {
  if (!plan_.stops) return;
  PartedWays parted = FindPartedWays(plan_.rows, channel_, gain_, gravity_g_s_);
  for (const std::size_t row : parted.rows) plan_.rows[row].usable[channel_] = false;
  defects_ = std::move(parted.defects);
  for (const Defect& defect : defects_) result->remarks.push_back(SaysOf(defect, parted.too_many));
}

void ChannelScale::ChooseColumns() {
  for (std::size_t other = 0; other < 3; ++other) {
    if (other == channel_) continue;
    const bool turned =
        plan_.stops
            ? CountTurns(plan_.rows, other).rotation_deg >= estimation_.options.min_rotation_deg
            : RotationRange(estimation_.columns, other) >= estimation_.options.min_rotation_deg;
    if (turned) problem_.others.push_back(other);
  }
  const TemperatureRange range = Temperatures(plan_.rows, channel_);
  problem_.mean_degC = range.mean;
  if (range.max - range.min < estimation_.options.min_temperature_range_degC ||
      !std::isfinite(range.mean))
    return;
  const bool everywhere = std::all_of(plan_.rows.begin(), plan_.rows.end(), [](const Row& row) {
    return std::isfinite(row.temperature_degC);
  });
  if (everywhere) problem_.bias_orders = kMaxBiasOrder;
}

// Whether this axis's rotation can be told from the others'.
bool ChannelScale::Separable(const IntervalSeries& series) const {
  const WhiteGram gram = Whiten(series, NoiseModel{1.0, 0.0, 0.0});
  const GlsSolution with = Solve(gram, problem_.Options(0).regressors, problem_.output());
  const std::array<int, 2> own = {0, problem_.bias_column()};
  const GlsSolution without = Solve(gram, own, problem_.output());
  return with.solvable && without.solvable && with.variance(0) < kInseparable * without.variance(0);
}

// All axes of the sensor that turned, turned by a fixed share of one another: the scale factor
// contains the cross-axis sensitivity to as much of them. False where that leaves next to nothing.
bool ChannelScale::TakeTogether(const IntervalSeries& series, ScaleResult* result,
                                std::string* reason) {
  const WhiteGram gram = Whiten(series, NoiseModel{1.0, 0.0, 0.0});
  const std::array<int, 2> own = {0, problem_.bias_column()};
  double square = 0.0;
  for (std::size_t k = 0; k < problem_.others.size(); ++k) {
    const GlsSolution with_own = Solve(gram, own, static_cast<int>(k) + 1);
    if (with_own.solvable) square += std::pow(kMostCrossAxis * with_own.coefficients[0], 2);
  }
  const double most = std::sqrt(square);
  if (!(most <= kScaleOfDataSheet)) {
    *reason = fmt::format(
        "its axis turned only with the others, and by {:.2g} of what they did: cross-axis "
        "sensitivity alone may make {:.2g} % of it; turn about this axis",
        kMostCrossAxis / most, 100.0 * most);
    return false;
  }
  problem_.others.clear();
  more_variance_ += kUniform * kUniform * square;
  result->remarks.push_back(fmt::format(
      "the axes turned only together: cross-axis sensitivity is contained in the scale factor, and "
      "the standard error allows for up to {:.2g} % of it",
      100.0 * most));
  return true;
}

// The reference's error [deg] where so few turns do not show it.
double ChannelScale::UnseenReference(std::int64_t count, const std::string& what,
                                     ScaleResult* result) const {
  const std::string few = fmt::format("{} {}{} too few to see the reference's error", count, what,
                                      count == 1 ? " is" : "s are");
  if (info_.stop_accuracy_deg) {
    result->remarks.push_back(fmt::format("{}: ±{:.3g} deg of the shaft's accuracy is used", few,
                                          *info_.stop_accuracy_deg));
    // Uniform over ± the stop's accuracy.
    return kUniform * *info_.stop_accuracy_deg;
  }
  if (estimation_.columns.rests.empty()) {
    result->remarks.push_back(fmt::format(
        "{}, the shaft's accuracy is not given and there is no rest: the standard error allows for "
        "no error of the reference at their ends",
        few));
    return 0.0;
  }
  double scatter = 0.0;
  for (const Rest& rest : estimation_.columns.rests) scatter = std::max(scatter, rest.scatter_deg);
  result->remarks.push_back(
      fmt::format("{}, and the shaft's accuracy is not given: the standard error allows only for "
                  "the scatter of its readings at rest, {:.2g} deg",
                  few, scatter));
  return scatter;
}

void ChannelScale::ChooseReference(FitOptions* options, ScaleResult* result) {
  const int parameters = 1 + static_cast<int>(problem_.others.size());
  if (plan_.stops) {
    int moving = 0;
    for (const Row& row : plan_.rows) moving += !row.still && row.usable[channel_] ? 1 : 0;
    if (moving - parameters >= kTurnsForReference) return;
    options->known_reference_deg = UnseenReference(result->turns, "turn", result);
    return;
  }
  // From node to node the readings show how they scatter, and not what is wrong at both ends of one
  // long way: as in a turn that has not come to its rest.
  const OneWayRotations ways = CountOneWayRotations(estimation_.columns, channel_);
  if (ways.count == 0 || ways.count - parameters >= kTurnsForReference) return;
  const double reference_deg = UnseenReference(ways.count, "one-way rotation", result);
  // Of the sum of rotation times error over the sum of rotations squared.
  more_variance_ +=
      reference_deg * reference_deg * ways.ends_square_deg2 / (ways.square_deg2 * ways.square_deg2);
}

// The relative uncertainty of the reference, 0 where it is not said.
double ChannelScale::AddReference(ScaleResult* result) const {
  Vector3 range_deg = {};
  range_deg[channel_] = RotationRange(estimation_.columns, channel_);
  const ReferenceError error = MakeReferenceError(info_.reference_uncertainty, range_deg);
  if (!error.said) return 0.0;
  result->reference_uncertainty = error.OfScale(channel_);
  return result->reference_uncertainty;
}

void ChannelScale::ReportPaper(ScaleResult* result) const {
  if (!plan_.stops) {
    result->remarks.push_back("no rests between turns: the paper's eq. (4), (5) do not apply");
    return;
  }
  const PaperScale paper = EstimatePaperScale(plan_.rows, channel_);
  result->paper_alpha = paper.alpha;
  result->paper_alpha_std_error = paper.alpha_std_error;
  result->paper_first_rest_alpha = paper.first_rest_alpha;
}

// What the scale's variance must grow by where the model leaves structure in the residuals: to that
// of the scores by blocks, and by what another weighting of the same data changes in the estimate.
double ChannelScale::AllowForStructure(const GlsFit& fit, const FitOptions& options,
                                       const IntervalSeries& series, double variance,
                                       ScaleResult* result) const {
  const double p_white =
      WhitenessPValue({fit.white_residuals.data(), series.rows()}, kWhitenessLags);
  if (p_white >= kNotWhite) return 0.0;
  double more = std::fmax(0.0, SandwichVariance(fit, 0) - variance);
  const std::vector<double> angles = SolveAngles(series, options.regressors, options.output);
  if (!plan_.stops && !angles.empty())
    more += std::pow(angles[0] - fit.solution.coefficients[0], 2);
  result->remarks.push_back(RemarkOnStructure(p_white, std::sqrt(1.0 + more / variance)));
  return more;
}

// Sensitivity to gravity makes the offset another in a turn about an axis that is not upright than
// at rest before and after it. Turns there and back cancel it, one turn does not. What 1 deg/s/g
// along each axis would add to the scale factor is the same fit with gravity in place of the
// output.
void ChannelScale::AllowForGravity(const GlsFit& fit, const FitOptions& options, double variance,
                                   ScaleResult* result) {
  if (gravity_g_s_.empty()) return;
  const WhiteGram gram =
      Whiten(problem_.GravitySeries(plan_.rows, channel_, gravity_g_s_), fit.noise);
  double square = 0.0;
  for (int k = 0; k < 3; ++k) {
    const GlsSolution solution = Solve(gram, options.regressors, problem_.output() + k);
    if (solution.solvable) square += std::pow(solution.coefficients[0], 2);
  }
  const double more = square * std::pow(kUniform * kGSensitivityOfDataSheet_deg_s_g, 2);
  const double m = fit.solution.coefficients[0];
  more_variance_ += more;
  if (!(m * m * more > (kWorthSaying * kWorthSaying - 1.0) * variance)) return;
  result->remarks.push_back(fmt::format(
      "an axis that is not upright turned farther one way than the other: g-sensitivity is "
      "contained in the scale factor, and the standard error allows for {:.2g} % of it",
      100.0 * std::sqrt(more)));
}

void ChannelScale::Report(const GlsFit& fit, const FitOptions& options,
                          const IntervalSeries& series, ScaleResult* result) {
  const GlsSolution& solution = fit.solution;
  const double m = solution.coefficients[0];
  double variance = solution.variance(0) * fit.inflation[0] * fit.inflation[0];
  variance += AllowForStructure(fit, options, series, variance, result);
  AllowForGravity(fit, options, variance, result);
  const double units = gain_ * m;
  result->alpha = 1.0 / units;
  const double relative = std::hypot(std::sqrt(variance) / std::fabs(m), std::sqrt(more_variance_));
  result->tick_ratio = estimation_.ticks.ratio();
  result->tick_ratio_std_error = estimation_.ticks.ratio_std_error();
  const double clock =
      std::isfinite(result->tick_ratio_std_error) ? result->tick_ratio_std_error : 0.0;
  result->alpha_statistical_std_error = std::fabs(result->alpha) * std::hypot(relative, clock);
  const double reference = AddReference(result);
  result->alpha_std_error = std::fabs(result->alpha) * std::hypot(relative, clock, reference);
  const double nominal = NominalUnitsPerDegPerS(info_);
  if (std::isfinite(nominal)) result->scale_error = result->alpha * nominal - 1.0;
  const auto bias_index = static_cast<std::size_t>(problem_.bias_column());
  const MeanBias mean = AverageBias(fit, options, bias_index);
  result->bias = gain_ * mean.value;
  result->bias_std_error = std::fabs(gain_) * std::sqrt(mean.variance) * fit.inflation[bias_index];
  // d alpha = -alpha dM / M
  result->alpha_bias_covariance = -result->alpha / m * gain_ * mean.covariance[0] *
                                  fit.inflation[0] * fit.inflation[bias_index];
  const TemperatureRange range = Temperatures(plan_.rows, channel_);
  result->bias_temperature_degC = range.mean;
  result->min_temperature_degC = range.min;
  result->max_temperature_degC = range.max;
  const double to_deg = 1.0 / std::fabs(m);
  result->noise = {fit.noise.angle_random_walk_deg_sqrt_s * to_deg,
                   fit.noise.bias_random_walk_deg_s_sqrt_s * to_deg,
                   fit.noise.reference_deg * to_deg};
  const double most_deg = MostReference(result);
  result->whitened_rms = WhitenedRms(series, options, fit.noise, most_deg * std::fabs(m));
  DescribeMotion(plan_.rows, channel_, units, result->bias, plan_.stops ? kLeastTurn_deg : 0.0,
                 result);
}

// Of the reference's noise, what can be its own: as the shaft's accuracy is given, or else as its
// rests show it, where the fit found much more. NaN where the fit's stands.
double ChannelScale::MostReference(ScaleResult* result) const {
  constexpr double kMuchMore = 3.0;
  const bool given = plan_.stops && info_.stop_accuracy_deg;
  const double stop_deg = given ? kUniform * *info_.stop_accuracy_deg : kMissing;
  const double own_deg = std::fmax(stop_deg, estimation_.reading_error_deg);
  const double found_deg = result->noise.reference_deg;
  if (!(found_deg > kMuchMore * own_deg)) return stop_deg;
  result->remarks.push_back(fmt::format(
      "reference noise of {:.2g} deg is {:.0f} times what {} ({:.2g} deg): it is what the model "
      "lacks (a nonlinearity, a ripple, a lag, play, an error of each stop), taken for noise. The "
      "errors contain it as noise, the whitened residual is by the reference's own; gyrobench "
      "trace looks for the cause",
      found_deg, found_deg / own_deg,
      own_deg > estimation_.reading_error_deg ? "the shaft's accuracy makes of it"
                                              : "its readings show at rest",
      own_deg));
  return own_deg;
}

// The columns, or why there can be none.
bool ChannelScale::SetUp(ScaleResult* result, std::string* reason, IntervalSeries* series) {
  plan_ = MakeScalePlan(estimation_.columns, channel_);
  const Turns turns =
      CountTurns(plan_.stops ? plan_.rows : StopRows(estimation_.columns, kScalePiece_s), channel_);
  const double turned = std::max(turns.rotation_deg, RotationRange(estimation_.columns, channel_));
  if (turned < estimation_.options.min_rotation_deg) {
    *reason = fmt::format("its axis turned by {:.3g} deg, at least {:.3g} is needed", turned,
                          estimation_.options.min_rotation_deg);
    return false;
  }
  gain_ = RoughGain(plan_.rows, channel_);
  if (!std::isfinite(gain_)) {
    *reason = fmt::format("its output does not follow the {:.3g} deg that its axis turned", turned);
    unfollowed_deg_ = turned;
    return false;
  }
  gravity_g_s_ = GravityOver(estimation_.columns, plan_.rows);
  LeaveOutWhatDisagrees(result);
  result->axis = static_cast<SensorAxis>(channel_);
  result->unit = OutputUnit(info_);
  result->turns = turns.count;
  result->schedule = plan_.stops ? "stops" : "continuous";
  ChooseColumns();
  *series = problem_.Series(plan_.rows, channel_, gain_);
  if (problem_.others.empty() || Separable(*series)) return true;
  if (!TakeTogether(*series, result, reason)) return false;
  *series = problem_.Series(plan_.rows, channel_, gain_);
  return true;
}

bool ChannelScale::Run(ScaleResult* result, std::string* reason) {
  IntervalSeries series(0);
  if (!SetUp(result, reason, &series)) return false;
  FitOptions options = problem_.Options(problem_.bias_orders);
  ChooseReference(&options, result);
  GlsFit fit = FitIntervals(series, options);
  if (fit.solvable && problem_.bias_orders > 0) {
    const std::size_t order =
        OrderOfLeastBic(Whiten(series, fit.noise), problem_.bias_orders,
                        [&](std::size_t shorter) { return problem_.Options(shorter); });
    FitOptions chosen = problem_.Options(order);
    chosen.known_reference_deg = options.known_reference_deg;
    if (order < problem_.bias_orders) fit = FitIntervals(series, chosen);
    options = chosen;
  }
  if (!fit.solvable) {
    *reason = fmt::format(
        "{} usable intervals are too few, or too alike, to tell scale factor and bias apart",
        series.rows());
    return false;
  }
  Report(fit, options, series, result);
  ReportPaper(result);
  return true;
}

}  // namespace

std::vector<ScaleResult> EstimateScale(const Estimation& estimation,
                                       std::vector<std::string>* remarks,
                                       std::array<double, 3>* unfollowed_deg,
                                       std::vector<Defect>* defects) {
  std::vector<ScaleResult> out;
  if (estimation.info.reference == ReferenceKind::kNone || estimation.columns.nodes.size() < 4)
    return out;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!estimation.usable[c]) continue;
    ScaleResult result;
    std::string reason;
    ChannelScale channel(estimation, c);
    const bool estimated = channel.Run(&result, &reason);
    AddDefects(channel.defects(), defects);
    if (estimated) {
      out.push_back(std::move(result));
    } else {
      (*unfollowed_deg)[c] = channel.unfollowed_deg();
      remarks->push_back(fmt::format("scale of {}: not estimated, {}", "xyz"[c], reason));
    }
  }
  return out;
}

std::string RemarkOnStructure(double p_white, double grown) {
  std::string remark =
      fmt::format("the whitened residuals are not white (p {}): the model leaves structure",
                  p_white < 1e-9 ? "< 1e-09" : fmt::format("= {:.1e}", p_white));
  if (grown >= kWorthSaying) {
    remark +=
        fmt::format("; the standard error allows for it and is {:.2f} times the model's", grown);
  }
  return remark;
}

}  // namespace gyrobench::calibration
