#include "calibration/estimators/bias.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/estimators/paper.h"
#include "calibration/estimators/part_ways.h"
#include "calibration/gls/noise_fit.h"
#include "calibration/gls/polynomial.h"
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
  GlsFit Fit(const std::vector<Row>& rows, IntervalSeries* series, std::size_t* order,
             std::string* reason);
  void Report(const GlsFit& fit, std::size_t order, BiasResult* result) const;
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

void ChannelBias::Report(const GlsFit& fit, std::size_t order, BiasResult* result) const {
  const std::size_t n = order + 1;
  const bool temperature = std::isfinite(result->reference_temperature_degC);
  const double reference = temperature ? result->reference_temperature_degC : scale_.middle_degC;
  std::vector<double> a = fit.solution.coefficients, covariance = fit.solution.covariance;
  for (double& value : a) value *= units_;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      covariance[i * n + j] *= units_ * units_ * fit.inflation[i] * fit.inflation[j];
    }
  }
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

// With the order of the bias's polynomial that the data ask for; `longest_` and the series follow
// where they cannot tell so many coefficients apart. `reason`: why it is not solvable.
GlsFit ChannelBias::Fit(const std::vector<Row>& rows, IntervalSeries* series, std::size_t* order,
                        std::string* reason) {
  GlsFit fit = FitIntervals(*series, Options(longest_));
  while (!fit.solvable && longest_ > 0) {
    --longest_;
    *series = Series(rows);
    fit = FitIntervals(*series, Options(longest_));
  }
  if (!fit.solvable) {
    *reason = "its output at rest is the same throughout or not a number";
    return fit;
  }
  *order = OrderOfLeastBic(Whiten(*series, fit.noise), longest_,
                           [&](std::size_t shorter) { return Options(shorter); });
  if (*order < longest_) fit = FitIntervals(*series, Options(*order));
  if (!fit.solvable) *reason = "the fit of the chosen order failed";
  return fit;
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
  std::size_t order = 0;
  const GlsFit fit = Fit(rows, &series, &order, reason);
  if (!fit.solvable) return false;
  Report(fit, order, result);
  ReportPaper(series, rows, result);
  double square = 0.0, usable = 0.0;
  for (const Row& row : rows) {
    if (!row.usable[channel_]) continue;
    result->duration_s += row.duration_s();
    const double x = order > 0 ? row.temperature_degC - result->reference_temperature_degC : 0.0;
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
