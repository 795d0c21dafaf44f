#include "calibration/gls/group_offsets.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/minimize.h"
#include "calibration/gls/statistics.h"
#include "calibration/gls/white_products.h"

namespace gyrobench::calibration {
namespace {

// Chance of either test to see groups that differ where they do not.
constexpr double kFirstLook = 0.01, kSeen = 0.001;
// Natural logarithms of K/N [1/s] and of spread/N [1/sqrt(s)].
constexpr double kLeastWalk = -14.0, kMostWalk = 3.0, kLeastSpread = -8.0, kMostSpread = 12.0;
constexpr double kNoSpread = -std::numeric_limits<double>::infinity();
constexpr double kNever = std::numeric_limits<double>::infinity();

}  // namespace

struct GroupedOffsets::Products {
  Eigen::MatrixXd all;
  Eigen::Index fixed = 0;
  double log_det = 0.0;
};

struct GroupedOffsets::Profile {
  double deviance = kNever, n = 0.0;  // -2 log of the restricted likelihood; N that suits best
};

GroupedOffsets::GroupedOffsets(const IntervalSeries& series, const std::vector<std::size_t>& group,
                               int duration, int output)
    : intervals_(series.intervals()),
      values_(series.values()),
      duration_(duration),
      output_(output) {
  const auto time = values_.col(duration);
  mean_ = values_.col(output).sum() / time.sum();
  values_.col(output) -= mean_ * time;
  const std::size_t given = group.empty() ? 0 : group.back() + 1;
  const std::size_t count = std::min(given, kMostGroups);
  groups_ = Eigen::MatrixXd::Zero(values_.rows(), static_cast<Eigen::Index>(count));
  for (std::size_t i = 0; i < group.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    groups_(row, static_cast<Eigen::Index>(group[i] * count / given)) = time(row);
  }
}

GroupedOffsets::Products GroupedOffsets::At(double walk, const std::vector<int>& regressors) const {
  const auto fixed = static_cast<Eigen::Index>(regressors.size());
  RowMajor columns(values_.rows(), fixed + groups_.cols() + 1);
  columns << values_(Eigen::all, regressors), groups_, values_.col(output_);
  WhiteProducts white = ProductsUnder(intervals_, ColumnsInChunks(columns), {1.0, walk, 0.0});
  return {std::move(white.products), fixed, white.log_det};
}

// With Z the groups' columns, q of them, t = spread/N, and all columns white under N = 1:
//   M = [X'X, X'Z; Z'X, Z'Z + 1/t^2]    of the mixed model (Henderson 1975)
//   -2 log L = log|R| + log|M| + q log t^2 + (n - p) (log N^2 + 1)
GroupedOffsets::Profile GroupedOffsets::ProfileOf(const Products& products,
                                                  double log_spread) const {
  const bool spread = log_spread > kNoSpread;
  const Eigen::Index p = products.fixed + (spread ? groups_.cols() : 0);
  const Eigen::Index output = products.all.rows() - 1;
  Eigen::MatrixXd m = products.all.topLeftCorner(p, p);
  if (spread) m.diagonal().tail(groups_.cols()).array() += std::exp(-2.0 * log_spread);
  const Eigen::VectorXd scale = m.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Eigen::MatrixXd> factor(scale.asDiagonal() * m * scale.asDiagonal());
  if (factor.info() != Eigen::Success) return {};
  const Eigen::VectorXd right = scale.cwiseProduct(products.all.col(output).head(p));
  const double square = products.all(output, output) - factor.matrixL().solve(right).squaredNorm();
  const auto freedom = static_cast<double>(values_.rows() - products.fixed);
  const double log_m =
      2.0 * (factor.matrixLLT().diagonal().array().log().sum() - scale.array().log().sum());
  Profile out;
  out.n = std::max(std::sqrt(std::max(square, 0.0) / freedom), kLeastAngleRandomWalk);
  out.deviance = products.log_det + log_m + freedom * (2.0 * std::log(out.n) + 1.0);
  if (spread) out.deviance += 2.0 * static_cast<double>(groups_.cols()) * log_spread;
  return out;
}

// A first look, that costs next to nothing: whether the means of the groups scatter by more than
// white noise as it is within them makes of them. Where not, neither walk nor spread does it.
bool GroupedOffsets::Differ(const std::vector<int>& regressors) const {
  const Products products = At(0.0, regressors);
  const Eigen::Index output = products.all.rows() - 1;
  const Eigen::Index p = products.fixed;
  const auto left = [&](Eigen::Index count) {
    const Eigen::VectorXd right = products.all.col(output).head(count);
    const Eigen::VectorXd fit = SolveIndependent(products.all.topLeftCorner(count, count), right);
    return products.all(output, output) - fit.dot(right);
  };
  const double within = left(output), freedom = static_cast<double>(values_.rows() - output);
  if (!(within > 0.0) || !(freedom > 0.0)) return false;
  const double scatter = (left(p) - within) / (within / freedom);
  return scatter > ChiSquareQuantile(std::log(kFirstLook),
                                     static_cast<double>(std::max<Eigen::Index>(output - p, 1)));
}

std::optional<GroupNoise> GroupedOffsets::Find(const std::vector<int>& regressors) const {
  const auto p = static_cast<Eigen::Index>(regressors.size());
  if (groups_.cols() <= p || values_.rows() <= groups_.cols() + p) return std::nullopt;
  if (!values_.allFinite() || !Differ(regressors)) return std::nullopt;
  // At each walk the best spread is found from the same products.
  double log_spread = 3.0;
  Profile best;
  const auto with = [&](const std::vector<double>& walk) {
    const Products products = At(std::exp(walk[0]), regressors);
    const Minimum at =
        Minimize([&](const std::vector<double>& u) { return ProfileOf(products, u[0]).deviance; },
                 {log_spread}, 1.0, {kLeastSpread}, {kMostSpread}, 0.01, 60);
    log_spread = at.at[0];
    best = ProfileOf(products, log_spread);
    return best.deviance;
  };
  const auto without = [&](const std::vector<double>& walk) {
    return ProfileOf(At(std::exp(walk[0]), regressors), kNoSpread).deviance;
  };
  const auto search = [](const std::function<double(const std::vector<double>&)>& deviance) {
    const double slow = deviance({-7.0}), fast = deviance({-3.5});
    return Minimize(deviance, {slow < fast ? -7.0 : -3.5}, 1.0, {kLeastWalk}, {kMostWalk}, 0.02,
                    60);
  };
  const Minimum least = search(without), most = search(with);
  // The spread is not less than 0: half of the time it is 0 by chance.
  const double level = ChiSquareQuantile(std::log(2.0 * kSeen), 1.0);
  if (!(least.value - with(most.at) > level)) return std::nullopt;
  const double walk = most.at[0] > kLeastWalk + 1.0 ? std::exp(most.at[0]) : 0.0;
  return GroupNoise{{best.n, best.n * walk, 0.0},
                    best.n * std::exp(log_spread),
                    static_cast<std::size_t>(groups_.cols())};
}

GlsSolution GroupedOffsets::Solve(const GroupNoise& noise,
                                  const std::vector<int>& regressors) const {
  const double n = noise.noise.angle_random_walk_deg_sqrt_s;
  const Products products = At(noise.noise.bias_random_walk_deg_s_sqrt_s / n, regressors);
  const Eigen::Index p = products.fixed, all = p + groups_.cols();
  WhiteGram gram;
  gram.rows = intervals_.size();
  gram.products = products.all / (n * n);
  gram.products.diagonal().segment(p, groups_.cols()).array() +=
      1.0 / (noise.spread_deg_s * noise.spread_deg_s);
  std::vector<int> every;
  for (int j = 0; j < static_cast<int>(all); ++j) every.push_back(j);
  const GlsSolution mixed = calibration::Solve(gram, every, static_cast<int>(all));
  GlsSolution out;
  if (!mixed.solvable) return out;
  out = mixed;
  const std::size_t kept = regressors.size(), size = every.size();
  out.coefficients.resize(kept);
  out.covariance.resize(kept * kept);
  for (std::size_t i = 0; i < kept; ++i) {
    if (regressors[i] == duration_) out.coefficients[i] += mean_;
    for (std::size_t j = 0; j < kept; ++j)
      out.covariance[i * kept + j] = mixed.covariance[i * size + j];
  }
  return out;
}

}  // namespace gyrobench::calibration
