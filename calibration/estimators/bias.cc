#include "calibration/estimators/bias.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "calibration/estimators/paper.h"
#include "calibration/estimators/part_ways.h"
#include "calibration/gls/group_offsets.h"
#include "calibration/gls/noise_fit.h"
#include "calibration/gls/polynomial.h"
#include "calibration/gls/statistics.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLongestPiece_s = 1.0;
constexpr double kMostPieces = 1500.0;  // longer rests go in longer pieces: the bias walks slowly
constexpr double kFewestPieces = 20.0;
constexpr std::size_t kFewestRows = 8;
constexpr int kCurvePoints = 101;

double RestTime(const Columns& columns) {
  double time_s = 0.0;
  for (const Rest& rest : columns.rests) time_s += rest.end.t_s - rest.begin.t_s;
  return time_s;
}

// A polynomial of the temperature: one coefficient more than the order.
struct BiasFit {
  std::vector<double> coefficients, covariance;
  NoiseModel noise;
  // Of the random walk over all rests, from where the first begins [deg/s]; 0 where it is not known
  // what that means, as the offset is another in each rest.
  double mean_walk = 0.0;
  std::size_t order() const { return coefficients.size() - 1; }
};

// Errors of estimated noises: each standard error grows by its factor.
BiasFit Inflated(const GlsSolution& solution, const std::vector<double>& inflation,
                 const NoiseModel& noise) {
  const std::size_t n = solution.coefficients.size();
  BiasFit fit{solution.coefficients, solution.covariance, noise};
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) fit.covariance[i * n + j] *= inflation[i] * inflation[j];
  }
  return fit;
}

class ChannelBias {
 public:
  ChannelBias(const Estimation& estimation, std::size_t channel, double units, bool units_known)
      : estimation_(estimation), channel_(channel), units_(units), units_known_(units_known) {}

  bool Run(BiasResult* result, std::string* reason);
  const std::vector<Defect>& defects() const { return defects_; }

 private:
  IntervalSeries Series(const std::vector<Row>& rows) const;
  FitOptions Options(std::size_t order) const;
  std::size_t LongestOrder(const TemperatureRange& range, BiasResult* result) const;
  std::optional<BiasFit> Fit(const std::vector<Row>& rows, IntervalSeries* series,
                             std::string* reason);
  void RemarkOnWalk(const BiasFit& fit, BiasResult* result) const;
  std::optional<BiasFit> FitRestByRest(const IntervalSeries& series, const std::vector<Row>& rows,
                                       BiasResult* result) const;
  void Report(const BiasFit& fit, BiasResult* result) const;
  void ReportPaper(const IntervalSeries& series, const std::vector<Row>& rows,
                   BiasResult* result) const;
  double Output(const Row& row) const {
    return (row.z[channel_] - units_ * row.earth_deg[channel_]) / row.duration_s();
  }

  const Estimation& estimation_;
  std::size_t channel_;
  double units_;  // output units per deg/s
  bool units_known_;
  TemperatureScale scale_;
  std::size_t longest_ = 0;
  std::vector<Defect> defects_;
};

IntervalSeries ChannelBias::Series(const std::vector<Row>& rows) const {
  return MakeSeries(
      rows, channel_, static_cast<int>(longest_) + 2, [&](const Row& row, double* out) {
        double power = row.duration_s();
        for (std::size_t k = 0; k <= longest_; ++k, power *= scale_.u(row.temperature_degC))
          *out++ = power;
        *out = Output(row) * row.duration_s() / units_;
      });
}

FitOptions ChannelBias::Options(std::size_t order) const {
  FitOptions options;
  for (int i = 0; i <= static_cast<int>(order); ++i) options.regressors.push_back(i);
  options.rest_regressors = options.regressors;
  options.output = static_cast<int>(longest_) + 1;
  return options;
}

std::size_t ChannelBias::LongestOrder(const TemperatureRange& range, BiasResult* result) const {
  if (!std::isfinite(range.mean)) {
    result->remarks.push_back(
        "no temperature in the data: the bias is one number, its dependence on temperature is not "
        "estimated");
    return 0;
  }
  if (range.max - range.min < estimation_.options.min_temperature_range_degC) {
    result->remarks.push_back(fmt::format(
        "temperature varied by {:.2g} degC, at least {:.2g} is needed: the bias is one number",
        range.max - range.min, estimation_.options.min_temperature_range_degC));
    return 0;
  }
  return static_cast<std::size_t>(std::clamp(estimation_.options.max_bias_order, 0, 5));
}

void ChannelBias::Report(const BiasFit& fit, BiasResult* result) const {
  const std::size_t n = fit.coefficients.size();
  const bool temperature = std::isfinite(result->reference_temperature_degC);
  const double reference = temperature ? result->reference_temperature_degC : scale_.middle_degC;
  std::vector<double> a = fit.coefficients, covariance = fit.covariance;
  for (double& value : a) value *= units_;
  for (double& value : covariance) value *= units_ * units_;
  const std::vector<double> l = ToPowersOf(scale_, reference, n);
  result->coefficients = Transformed(l, a);
  const std::vector<double> c = TransformedCovariance(l, covariance, n);
  result->covariance.assign(n, std::vector<double>(n));
  result->std_errors.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) result->covariance[i][j] = c[i * n + j];
    result->std_errors[i] = std::sqrt(c[i * n + i]);
  }
  double square = 0.0;
  for (int k = 0; k < kCurvePoints; ++k) {
    const double u = -1.0 + 2.0 * k / (kCurvePoints - 1);
    std::vector<double> powers(n, 1.0);
    for (std::size_t i = 1; i < n; ++i) powers[i] = powers[i - 1] * u;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) square += powers[i] * covariance[i * n + j] * powers[j];
    }
  }
  result->rms_error = std::sqrt(square / kCurvePoints);
  if (units_known_) {
    result->noise.angle_random_walk_deg_sqrt_s = fit.noise.angle_random_walk_deg_sqrt_s;
    result->noise.bias_random_walk_deg_s_sqrt_s = fit.noise.bias_random_walk_deg_s_sqrt_s;
  }
}

void ChannelBias::ReportPaper(const IntervalSeries& series, const std::vector<Row>& rows,
                              BiasResult* result) const {
  std::vector<double> output, u;
  for (const Row& row : rows) {
    if (!row.usable[channel_]) continue;
    output.push_back(Output(row));
    u.push_back(longest_ > 0 ? scale_.u(row.temperature_degC) : 0.0);
  }
  const double reference = longest_ > 0 ? result->reference_temperature_degC : scale_.middle_degC;
  // The smoother knows no temperature: its random walk is all that the bias does.
  const NoiseModel noise = FitNoise(series, Options(0)).value_or(NoiseModel{0.0, 0.0, 0.0});
  const NoiseModel units = {noise.angle_random_walk_deg_sqrt_s * std::fabs(units_),
                            noise.bias_random_walk_deg_s_sqrt_s * std::fabs(units_), 0.0};
  const PaperBias paper = EstimatePaperBias(series, units, output, u, longest_);
  result->paper_coefficients =
      Transformed(ToPowersOf(scale_, reference, paper.coefficients.size()), paper.coefficients);
  result->paper_rms_error = paper.rms_error;
}

// Where the offset is another in each rest: another pose and a sensitivity to gravity, or what else
// the polynomial does not know. A random walk alone would have to walk as far within the rests,
// which they contradict, and say next to nothing of the offset but at its begin.
std::optional<BiasFit> ChannelBias::FitRestByRest(const IntervalSeries& series,
                                                  const std::vector<Row>& rows,
                                                  BiasResult* result) const {
  std::vector<std::size_t> rest_of_row;
  std::size_t rests = 0, last = 0;
  for (const Row& row : rows) {
    if (!row.usable[channel_]) continue;
    if (rests == 0 || row.rest != last) ++rests;
    last = row.rest;
    rest_of_row.push_back(rests - 1);
  }
  const GroupedOffsets grouped(series, rest_of_row, 0, static_cast<int>(longest_) + 1);
  // A polynomial with nearly as many coefficients as there are rests would take the scatter in.
  constexpr std::size_t kRestsForCoefficient = 3;
  const std::size_t most =
      std::min(longest_, std::max(rests / kRestsForCoefficient, std::size_t{1}) - 1);
  const std::optional<GroupNoise> noise = grouped.Find(Options(most).regressors);
  if (!noise) return std::nullopt;
  GlsSolution best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t order = 0; order <= most; ++order) {
    const GlsSolution solution = grouped.Solve(*noise, Options(order).regressors);
    const double bic = solution.residual_square +
                       static_cast<double>(order) * std::log(static_cast<double>(noise->groups));
    if (!solution.solvable || !(bic < least)) continue;
    least = bic;
    best = solution;
  }
  if (!best.solvable) return std::nullopt;
  // The spread is known by the groups alone.
  const double freedom =
      static_cast<double>(noise->groups) - static_cast<double>(best.coefficients.size());
  const std::vector<double> inflation(best.coefficients.size(),
                                      StudentInflation(std::max(freedom, 2.0)));
  result->offset_scatter = std::fabs(units_) * noise->spread_deg_s;
  result->offset_groups = static_cast<std::int64_t>(noise->groups);
  result->remarks.push_back(fmt::format(
      "the offset differs from rest to rest by {:.3g} {} rms, more than noise and random walk "
      "explain: by sensitivity to gravity where the pose changed, or by what else beta(T) does not "
      "know; c0 is the mean of {} rests, and the errors allow for it; gyrobench trace looks for "
      "the cause",
      result->offset_scatter, result->unit, rests));
  return Inflated(best, inflation, noise->noise);
}

// With the order of the bias's polynomial that the data ask for; `longest_` and the series follow
// where they cannot tell so many coefficients apart. `reason`: why it is not solvable.
std::optional<BiasFit> ChannelBias::Fit(const std::vector<Row>& rows, IntervalSeries* series,
                                        std::string* reason) {
  GlsFit fit = FitIntervals(*series, Options(longest_));
  while (!fit.solvable && longest_ > 0) {
    --longest_;
    *series = Series(rows);
    fit = FitIntervals(*series, Options(longest_));
  }
  if (!fit.solvable) {
    *reason = "its output at rest is the same throughout or not a number";
    return std::nullopt;
  }
  const std::size_t order = OrderOfLeastBic(Whiten(*series, fit.noise), longest_,
                                            [&](std::size_t shorter) { return Options(shorter); });
  if (order < longest_) fit = FitIntervals(*series, Options(order));
  if (!fit.solvable) {
    *reason = "the fit of the chosen order failed";
    return std::nullopt;
  }
  BiasFit out = Inflated(fit.solution, fit.inflation, fit.noise);
  out.mean_walk = AverageBias(fit, Options(order), 0).value - out.coefficients[0];
  return out;
}

// c0 is the offset as the measurement begins; the scale factor's bias is a mean.
void ChannelBias::RemarkOnWalk(const BiasFit& fit, BiasResult* result) const {
  constexpr double kClearly = 2.0;
  const double walk = units_ * fit.mean_walk;
  if (!(std::fabs(walk) > kClearly * result->std_errors[0])) return;
  result->remarks.push_back(
      fmt::format("c0 is the offset as the rests begin; it walks by {:.3g} {} in their mean, which "
                  "is {:.6g} {} at T_ref",
                  walk, result->unit, result->coefficients[0] + walk, result->unit));
}

bool ChannelBias::Run(BiasResult* result, std::string* reason) {
  const double rest_s = RestTime(estimation_.columns);
  const double piece_s = rest_s > kMostPieces ? rest_s / kMostPieces
                                              : std::min(kLongestPiece_s, rest_s / kFewestPieces);
  std::vector<Row> rows = RestRows(estimation_.columns, piece_s);
  if (units_known_ && estimation_.info.reference != ReferenceKind::kNone) {
    PartedWays parted = FindPartedWays(rows, channel_, units_);
    for (const std::size_t row : parted.rows) rows[row].usable[channel_] = false;
    defects_ = std::move(parted.defects);
  }
  const TemperatureRange range = Temperatures(rows, channel_);
  result->axis = static_cast<SensorAxis>(channel_);
  result->unit = OutputUnit(estimation_.info);
  result->reference_temperature_degC = range.mean;
  result->min_temperature_degC = range.min;
  result->max_temperature_degC = range.max;
  longest_ = LongestOrder(range, result);
  if (longest_ > 0) {
    scale_ = {0.5 * (range.min + range.max), 0.5 * (range.max - range.min)};
    // A row without temperature has no place on the curve.
    std::erase_if(rows, [](const Row& row) { return !std::isfinite(row.temperature_degC); });
  }
  IntervalSeries series = Series(rows);
  if (series.rows() < kFewestRows) {
    *reason = fmt::format("{:.2g} s at rest in {} usable pieces, at least {} are needed", rest_s,
                          series.rows(), kFewestRows);
    return false;
  }
  if (longest_ > series.rows() / 4) {
    longest_ = series.rows() / 4;
    series = Series(rows);  // its columns follow the longest polynomial
  }
  std::optional<BiasFit> fit = Fit(rows, &series, reason);
  if (!fit) return false;
  if (std::optional<BiasFit> by_rest = FitRestByRest(series, rows, result)) fit = by_rest;
  Report(*fit, result);
  RemarkOnWalk(*fit, result);
  ReportPaper(series, rows, result);
  double square = 0.0, usable = 0.0;
  for (const Row& row : rows) {
    if (!row.usable[channel_]) continue;
    result->duration_s += row.duration_s();
    const double x =
        fit->order() > 0 ? row.temperature_degC - result->reference_temperature_degC : 0.0;
    square += std::pow(Output(row) - Evaluate(result->coefficients, x), 2);
    usable += 1.0;
  }
  result->residual_rms = std::sqrt(square / usable);
  return true;
}

}  // namespace

std::vector<BiasResult> EstimateBias(const Estimation& estimation,
                                     const std::vector<ScaleResult>& scale,
                                     std::vector<std::string>* remarks,
                                     std::vector<Defect>* defects) {
  std::vector<BiasResult> out;
  if (estimation.columns.rests.empty()) {
    if (estimation.info.reference != ReferenceKind::kNone) {
      remarks->push_back(
          "the reference never rests: no bias against temperature, only the one next to each scale "
          "factor");
    }
    return out;
  }
  for (std::size_t c = 0; c < 3; ++c) {
    if (!estimation.usable[c]) continue;
    double units = NominalUnitsPerDegPerS(estimation.info);
    for (const ScaleResult& result : scale) {
      if (static_cast<std::size_t>(result.axis) == c) units = 1.0 / result.alpha;
    }
    const bool known = std::isfinite(units);
    if (!known) units = 1.0;
    BiasResult result;
    std::string reason;
    if (!known) {
      result.remarks.push_back(
          "the sensitivity is not known: no noise in deg, Earth's rotation stays in the bias");
    }
    ChannelBias channel(estimation, c, units, known);
    const bool estimated = channel.Run(&result, &reason);
    AddDefects(channel.defects(), defects);
    if (estimated) {
      out.push_back(std::move(result));
    } else {
      remarks->push_back(fmt::format("bias of {}: not estimated, {}", "xyz"[c], reason));
    }
  }
  return out;
}

}  // namespace gyrobench::calibration
