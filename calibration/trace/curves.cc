#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <optional>
#include <unsupported/Eigen/FFT>

#include "base/geometry.h"
#include "calibration/effects/factor.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/held_out.h"
#include "calibration/trace/report_parts.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kMostPoints = 1500;
constexpr std::size_t kBins = 40;

// Residual increments of the fit on part of its columns, best for that part.
struct Residuals {
  Eigen::VectorXd raw_before, raw_after, white_before, white_after;
};

Residuals MakeResiduals(const ChannelProblem& problem, const ChannelFit& fit,
                        const Selection& selection) {
  Residuals out;
  const Eigen::VectorXd base = selection.store().Solve(selection.baseline_columns());
  const Eigen::Index count = fit.baseline_columns;
  out.raw_before = problem.output_deg() - fit.raw.leftCols(count) * base;
  out.white_before = fit.white_output - fit.white.leftCols(count) * base;
  out.raw_after = problem.output_deg() - fit.raw * fit.linear;
  out.white_after = fit.WhiteResidual();
  return out;
}

Series ByTime(const ChannelProblem& problem, const Eigen::VectorXd& before,
              const Eigen::VectorXd& after) {
  Series out;
  const Eigen::Index step =
      std::max<Eigen::Index>(1, problem.rows() / static_cast<Eigen::Index>(kMostPoints));
  double origin = 0.0, last = 0.0;
  for (Eigen::Index i = 0; i < problem.rows(); i += step) {
    // Measurements one after the other.
    if (problem.end_s(i) + origin < last) origin = last - problem.end_s(i);
    last = problem.end_s(i) + origin;
    out.x.push_back(last);
    out.before.push_back(before(i));
    out.after.push_back(after(i));
  }
  return out;
}

// Means in bins of equal width; bins with few rows are left out.
Series Binned(const ChannelProblem& problem, const std::function<double(Eigen::Index)>& value,
              const Eigen::VectorXd& before, const Eigen::VectorXd& after,
              const std::function<double(Eigen::Index)>& weight) {
  Series out;
  double low = kMissing, high = kMissing;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    low = std::fmin(low, value(i));
    high = std::fmax(high, value(i));
  }
  if (!(high > low)) return out;
  std::vector<double> sum_before(kBins, 0.0), sum_after(kBins, 0.0), sum(kBins, 0.0), x(kBins, 0.0);
  std::vector<int> count(kBins, 0);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const double v = value(i);
    if (!std::isfinite(v)) continue;
    const auto bin = std::min(
        kBins - 1, static_cast<std::size_t>((v - low) / (high - low) * static_cast<double>(kBins)));
    sum_before[bin] += before(i);
    sum_after[bin] += after(i);
    sum[bin] += weight(i);
    x[bin] += v;
    ++count[bin];
  }
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    if (count[bin] < 5) continue;
    out.x.push_back(x[bin] / count[bin]);
    out.before.push_back(sum_before[bin] / sum[bin]);
    out.after.push_back(sum_after[bin] / sum[bin]);
  }
  return out;
}

// Mean periodogram of segments, relative to white noise of unit variance.
std::vector<double> Spectrum(const Eigen::VectorXd& white, std::size_t segment) {
  std::vector<double> power(segment / 2, 0.0), buffer(segment);
  std::vector<std::complex<double>> transform;
  Eigen::FFT<double> fft;
  double segments = 0.0;
  for (std::size_t begin = 0; begin + segment <= static_cast<std::size_t>(white.size());
       begin += segment / 2) {
    double window = 0.0;
    for (std::size_t i = 0; i < segment; ++i) {
      const double w = std::sin(3.14159265358979 * (static_cast<double>(i) + 0.5) /
                                static_cast<double>(segment));
      buffer[i] = w * white(static_cast<Eigen::Index>(begin + i));
      window += w * w;
    }
    fft.fwd(transform, buffer);
    for (std::size_t f = 0; f < power.size(); ++f) power[f] += std::norm(transform[f]) / window;
    segments += 1.0;
  }
  for (double& value : power) value /= segments;
  return power;
}

Series SpectrumSeries(const ChannelProblem& problem, const Residuals& residuals) {
  Series out;
  std::size_t segment = 2048;
  while (segment > 64 && 4 * segment > static_cast<std::size_t>(problem.rows())) segment /= 2;
  if (4 * segment > static_cast<std::size_t>(problem.rows())) return out;
  double time_s = 0.0;
  for (const Interval& interval : problem.intervals()) time_s += interval.duration_s;
  const double rate_hz = static_cast<double>(problem.rows()) / time_s;
  const std::vector<double> before = Spectrum(residuals.white_before, segment);
  const std::vector<double> after = Spectrum(residuals.white_after, segment);
  // Bins that widen with frequency, so that a logarithmic axis is evenly filled.
  for (std::size_t f = 1; f < before.size();) {
    const std::size_t end = std::min(before.size(), std::max(f + 1, f + f / 12));
    double x = 0.0, a = 0.0, b = 0.0;
    for (std::size_t k = f; k < end; ++k) {
      x += static_cast<double>(k);
      a += before[k];
      b += after[k];
    }
    const auto n = static_cast<double>(end - f);
    out.x.push_back(x / n * rate_hz / static_cast<double>(segment));
    out.before.push_back(a / n);
    out.after.push_back(b / n);
    f = end;
  }
  return out;
}

// Overlapping Allan deviation over the longest rest, and what angle and bias random walk give:
//   N^2 / tau + K^2 tau / 3
std::vector<AllanPoint> Allan(const ChannelProblem& problem, const Eigen::VectorXd& increments,
                              const NoiseModel& noise) {
  std::vector<AllanPoint> out;
  Eigen::Index best = 0, length = 0, begin = 0;
  for (Eigen::Index i = 0; i <= problem.rows(); ++i) {
    const bool goes_on =
        i < problem.rows() && problem.intervals()[static_cast<std::size_t>(i)].still &&
        (i == begin || problem.intervals()[static_cast<std::size_t>(i)].gap_before_s == 0.0);
    if (goes_on) continue;
    if (i - begin > length) {
      length = i - begin;
      best = begin;
    }
    begin = i + 1;
  }
  if (length < 50) return out;
  std::vector<double> angle(static_cast<std::size_t>(length) + 1, 0.0);
  double time_s = 0.0;
  for (Eigen::Index i = 0; i < length; ++i) {
    angle[static_cast<std::size_t>(i) + 1] =
        angle[static_cast<std::size_t>(i)] + increments(best + i);
    time_s += problem.intervals()[static_cast<std::size_t>(best + i)].duration_s;
  }
  const double step_s = time_s / static_cast<double>(length);
  for (double exact = 1.0; exact < static_cast<double>(length) / 4.0; exact *= 1.5) {
    const auto m = static_cast<std::size_t>(std::lround(exact));
    const double tau = static_cast<double>(m) * step_s;
    double square = 0.0, n = 0.0;
    for (std::size_t i = 0; i + 2 * m < angle.size(); ++i) {
      const double change = angle[i + 2 * m] - 2.0 * angle[i + m] + angle[i];
      square += change * change;
      n += 1.0;
    }
    AllanPoint point;
    point.tau_s = tau;
    point.measured_deg_s = std::sqrt(square / (2.0 * tau * tau * n));
    const double freedom =
        std::max(1.0, static_cast<double>(angle.size()) / static_cast<double>(m) - 1.0);
    point.std_error_deg_s = point.measured_deg_s / std::sqrt(2.0 * freedom);
    point.model_deg_s = std::sqrt(std::pow(noise.angle_random_walk_deg_sqrt_s, 2) / tau +
                                  std::pow(noise.bias_random_walk_deg_s_sqrt_s, 2) * tau / 3.0);
    out.push_back(point);
  }
  return out;
}

// The quantity of its own that the first effect with one depends on: a column, or the first factor
// of a product or a ramp; rather one that has no chart otherwise.
std::optional<Factor> TracedFactor(const Selection& selection, std::size_t channel) {
  std::vector<std::string> names;
  for (const Candidate& member : selection.members()) {
    if (member.effect == nullptr) {
      names.insert(names.end(), member.factors.begin(), member.factors.end());
    } else if ((member.effect->needs & kNeedsCovariate) != 0) {
      names.push_back(selection.covariates()[member.context.covariate]);
    }
  }
  if (names.empty()) return std::nullopt;
  const auto own = std::find_if(names.begin(), names.end(),
                                [](const std::string& name) { return name != "w" && name != "T"; });
  return Factor::Make(own != names.end() ? *own : names.front(), channel, selection.covariates());
}

}  // namespace

ResidualCurves MakeCurves(const ChannelProblem& problem, const ChannelFit& fit,
                          const Selection& selection, const NoiseModel& noise) {
  ResidualCurves out;
  const Residuals residuals = MakeResiduals(problem, fit, selection);
  const Eigen::VectorXd before = AngleErrors(problem, residuals.raw_before);
  const Eigen::VectorXd after = AngleErrors(problem, residuals.raw_after);
  out.angle_error_by_time_s = ByTime(problem, before, after);
  auto duration = [&](Eigen::Index i) {
    return problem.intervals()[static_cast<std::size_t>(i)].duration_s;
  };
  auto rates = [&](const std::function<double(Eigen::Index)>& value) {
    return Binned(problem, value, residuals.raw_before, residuals.raw_after, duration);
  };
  const std::size_t c = problem.channel();
  out.rate_error_by_temperature_degC =
      rates([&](Eigen::Index i) { return problem.half(i, 0).temperature_degC; });
  out.rate_error_by_rate_deg_s =
      rates([&](Eigen::Index i) { return problem.half(i, 0).rate_deg_s[c]; });
  if (!problem.table_axes().empty()) {
    const std::size_t a = problem.table_axes().front();
    out.angle_error_by_table_angle_deg = Binned(
        problem,
        [&](Eigen::Index i) {
          const double turn = problem.end_node(i).table_deg[a] / kFullTurn_deg;
          return problem.half(i, 0).still ? kMissing : kFullTurn_deg * (turn - std::floor(turn));
        },
        before, after, [](Eigen::Index) { return 1.0; });
  }
  if (const std::optional<Factor> factor = TracedFactor(selection, c)) {
    out.traced_covariate = factor->unit().empty()
                               ? factor->name()
                               : fmt::format("{} [{}]", factor->name(), factor->unit());
    out.rate_error_by_traced_covariate =
        rates([&](Eigen::Index i) { return factor->At(problem.half(i, 0)); });
  }
  out.whitened_spectrum_by_hz = SpectrumSeries(problem, residuals);
  out.allan = Allan(problem, residuals.raw_after, noise);
  return out;
}

}  // namespace gyrobench::calibration
