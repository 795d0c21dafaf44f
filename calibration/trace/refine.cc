#include "calibration/trace/refine.h"

#include <ceres/dynamic_numeric_diff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "calibration/trace/scans.h"

namespace gyrobench::calibration {
namespace {

// Of the counts of a turn: an encoder of the measured data counts 0.25 % too little
// (docs/trace.md).
constexpr double kReferenceScale = 0.003;
constexpr double kMostOffWhole = 0.5;

using ColumnsAt = std::function<Eigen::MatrixXd(const std::vector<double>&)>;

// r - X (X'X)^-1 X' r
Eigen::VectorXd Projected(const ColumnsAt& columns, const Eigen::VectorXd& residual,
                          const std::vector<double>& theta) {
  const Eigen::MatrixXd x = columns(theta);
  const Eigen::VectorXd c = (x.transpose() * x).ldlt().solve(x.transpose() * residual);
  return residual - x * c;
}

// The parameters as places in their range, 1 to 2: a step of numeric differentiation, which is
// relative, then fits whatever the parameter's size is.
std::vector<double> FromPlaces(const double* places, const std::vector<double>& low,
                               const std::vector<double>& high) {
  std::vector<double> theta = low;
  for (std::size_t i = 0; i < theta.size(); ++i) theta[i] += (places[i] - 1.0) * (high[i] - low[i]);
  return theta;
}

// The solver asks for one point up to three times: as a step that it tries, as the step that it
// takes, and with its derivatives.
class Residual {
 public:
  Residual(const ColumnsAt& columns, const Eigen::VectorXd& residual,
           const std::vector<double>& low, const std::vector<double>& high)
      : columns_(columns), residual_(residual), low_(low), high_(high) {}

  bool operator()(double const* const* places, double* out) const {
    const Eigen::VectorXd& left = At(FromPlaces(places[0], low_, high_));
    if (!left.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(out, left.size()) = left;
    return true;
  }

  // Until the next call.
  const Eigen::VectorXd& At(const std::vector<double>& theta) const {
    for (const std::optional<Point>& point : last_) {
      if (point && point->theta == theta) return point->left;
    }
    std::optional<Point>& oldest = last_[next_++ % last_.size()];
    oldest = Point{theta, Projected(columns_, residual_, theta)};
    return oldest->left;
  }

 private:
  struct Point {
    std::vector<double> theta;
    Eigen::VectorXd left;
  };

  const ColumnsAt& columns_;
  const Eigen::VectorXd& residual_;
  const std::vector<double>&low_, &high_;
  mutable std::array<std::optional<Point>, 8> last_;
  mutable std::size_t next_ = 0;
};

// How far from the number of periods at which the scan has found a ripple it may be: as far from a
// whole one as it may; where that is any number, as far as the angles that were passed leave open.
double ReachOfPeriods(const ChannelProblem& problem, const Candidate& ripple) {
  constexpr double kFarthest = 5.0;
  const double off_whole = OffWholePeriods(ripple.context.nonlinear[0]);
  if (off_whole < kMostOffWhole) return off_whole;
  const double turns = TurnsSpanned(problem, ripple.context.table_axis);
  return std::clamp(1.0 / turns, off_whole, kFarthest);
}

}  // namespace

double OffWholePeriods(double periods) {
  return std::min(kReferenceScale * periods, kMostOffWhole);
}

std::optional<RefineRange> RangeOf(const ChannelProblem& problem, const Candidate& candidate) {
  if (candidate.empirical()) {
    const double from = candidate.knots[0], to = candidate.knots[1], width = to - from;
    return RefineRange{{0.5 * (from + to), width},
                       {from - 0.5 * width, 1e-3 * width},
                       {to + 0.5 * width, 2.0 * width}};
  }
  if (candidate.origin) {
    return RefineRange{
        candidate.context.nonlinear, {candidate.origin->low}, {candidate.origin->high}};
  }
  if (candidate.effect == nullptr || candidate.effect->nonlinear.empty()) return std::nullopt;
  const Effect& effect = *candidate.effect;
  RefineRange range;
  range.start = candidate.context.nonlinear;
  range.is_coefficient = effect.search == Search::kCoefficient;
  for (std::size_t i = 0; i < effect.nonlinear.size(); ++i) {
    const NonlinearParameter& parameter = effect.nonlinear[i];
    double low = parameter.low, high = parameter.high;
    // What a scan has found lies within its resolution.
    if (effect.search == Search::kFrequency) {
      const double width = 1.0 / (problem.end_s(problem.rows() - 1) - problem.begin_s(0));
      low = std::max(range.start[i] - width, 1e-6);
      high = range.start[i] + width;
    } else if (effect.search == Search::kPeriods) {
      const double reach = ReachOfPeriods(problem, candidate);
      low = std::round(range.start[i]) - reach;
      high = std::round(range.start[i]) + reach;
    }
    if (!(high > low)) return std::nullopt;
    range.low.push_back(low);
    range.high.push_back(high);
  }
  return range;
}

void SetNonlinear(const std::vector<double>& theta, Candidate* candidate) {
  candidate->raw.reset();
  if (candidate->empirical()) {
    candidate->knots = {theta[0] - 0.5 * theta[1], theta[0] + 0.5 * theta[1]};
  } else {
    candidate->context.nonlinear = theta;
    for (std::size_t f = 0; f < candidate->factors.size(); ++f) {
      if (candidate->factors[f] == candidate->origin->of) candidate->offsets[f] = theta[0];
    }
  }
}

std::vector<double> RefineNonlinear(const ColumnsAt& columns, const Eigen::VectorXd& residual,
                                    std::vector<double> start, const std::vector<double>& low,
                                    const std::vector<double>& high) {
  std::vector<double> places;
  for (std::size_t i = 0; i < start.size(); ++i)
    places.push_back(1.0 + std::clamp((start[i] - low[i]) / (high[i] - low[i]), 0.0, 1.0));
  ceres::NumericDiffOptions differences;
  differences.relative_step_size = 1e-4;
  Residual left(columns, residual, low, high);
  auto* cost = new ceres::DynamicNumericDiffCostFunction<Residual, ceres::CENTRAL>(
      &left, ceres::DO_NOT_TAKE_OWNERSHIP, differences);
  cost->AddParameterBlock(static_cast<int>(places.size()));
  cost->SetNumResiduals(static_cast<int>(residual.size()));
  ceres::Problem problem;
  problem.AddResidualBlock(cost, nullptr, places.data());
  for (std::size_t i = 0; i < places.size(); ++i) {
    problem.SetParameterLowerBound(places.data(), static_cast<int>(i), 1.0);
    problem.SetParameterUpperBound(places.data(), static_cast<int>(i), 2.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 40;
  options.function_tolerance = 1e-9;
  // Because of the bounds each step is searched along its line: by values alone, as a gradient costs
  // two more of them for each parameter.
  options.line_search_interpolation_type = ceres::QUADRATIC;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  const std::vector<double> theta = FromPlaces(places.data(), low, high);
  const bool better =
      summary.IsSolutionUsable() && left.At(theta).squaredNorm() <= left.At(start).squaredNorm();
  return better ? theta : start;
}

}  // namespace gyrobench::calibration
