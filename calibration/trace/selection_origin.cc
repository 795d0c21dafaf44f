// The temperature from which a product is counted.
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Share of a column's square outside the span of others below which it does what they do.
constexpr double kSameSpan = 1e-3;

std::optional<double> OriginOf(const Candidate& candidate) {
  const auto found = std::ranges::find(candidate.factors, "T");
  if (found == candidate.factors.end() || candidate.empirical()) return std::nullopt;
  return candidate.offsets[static_cast<std::size_t>(found - candidate.factors.begin())];
}

Candidate CountedFrom(const Candidate& product, double origin_degC) {
  Candidate out = product;
  SetNonlinear({origin_degC}, &out);
  out.columns.clear();
  return out;
}

// The gain of f (T - T0) for any T0, from products of f (T - T00), f and the output.
class GainByOrigin {
 public:
  GainByOrigin(const Eigen::MatrixXd& product, const Eigen::MatrixXd& factor,
               const Eigen::VectorXd& output)
      : products_(product.transpose() * product),
        mixed_(product.transpose() * factor + factor.transpose() * product),
        factors_(factor.transpose() * factor),
        with_product_(product.transpose() * output),
        with_factor_(factor.transpose() * output) {}

  double At(double lower_by_degC) const {
    return ScaledLdlt(products_ + lower_by_degC * mixed_ + lower_by_degC * lower_by_degC * factors_)
        .Square(with_product_ + lower_by_degC * with_factor_);
  }

 private:
  Eigen::MatrixXd products_, mixed_, factors_;
  Eigen::VectorXd with_product_, with_factor_;
};

}  // namespace

// f (T - T0) is the sum of f T and a part of f alone, whatever temperature T is counted from. The
// two are one cause where the data have the temperature T0, and where f has several terms and all
// parts agree in it.
void Selection::JoinOrigins() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!OriginOf(members_[i])) continue;
    for (std::size_t j = 0; j < members_.size(); ++j) {
      if (members_[j].effect == nullptr) continue;
      std::optional<Candidate> joined = Joined(i, j);
      if (!joined) continue;
      joined->columns = store_.Add(White(*joined));
      members_[i] = std::move(*joined);
      Remove(j);
      if (j < i) --i;
      break;
    }
  }
}

std::optional<Candidate> Selection::Joined(std::size_t product, std::size_t part) const {
  const double origin_degC = *OriginOf(members_[product]);
  const Eigen::MatrixXd whole = store_.Take(members_[product].columns);
  const Eigen::MatrixXd factor = White(CountedFrom(members_[product], origin_degC - 1.0)) - whole;
  const Eigen::MatrixXd plain = store_.Take(members_[part].columns);
  const Eigen::VectorXd outside = Projection(factor).Off(plain).colwise().squaredNorm();
  const Eigen::VectorXd squares = plain.colwise().squaredNorm();
  if ((outside.array() > kSameSpan * squares.array()).any()) return std::nullopt;
  WhiteStore::Columns others = ModelWithout(part);
  std::erase_if(others, [&](Eigen::Index column) {
    return std::ranges::count(members_[product].columns, column) > 0;
  });
  const Projection others_off(store_.Take(others));
  const Eigen::VectorXd output = others_off.Off(store_.output());
  const Eigen::MatrixXd whole_off = others_off.Off(whole), factor_off = others_off.Off(factor);
  const GainByOrigin gain(whole_off, factor_off, output);
  constexpr int kCells = 24, kBits = 20;
  const double low = origin_degC - problem_->max_temperature_degC();
  const double width =
      (problem_->max_temperature_degC() - problem_->min_temperature_degC()) / kCells;
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (int cell = 0; cell < kCells; ++cell) {
    const auto [at, minus_gain] = boost::math::tools::brent_find_minima(
        [&](double lower_by_degC) { return -gain.At(lower_by_degC); }, low + cell * width,
        low + (cell + 1) * width, kBits);
    if (!(minus_gain < least)) continue;
    least = minus_gain;
    best = at;
  }
  Eigen::MatrixXd both(store_.rows(), whole.cols() + plain.cols());
  both << whole_off, others_off.Off(plain);
  const double together = ScaledLdlt(both.transpose() * both).Square(both.transpose() * output);
  const auto freedom = static_cast<double>(std::max<Eigen::Index>(plain.cols() - 1, 1));
  if (LogChiSquareTail(together + least, freedom) < members_[part].log_level) return std::nullopt;
  return CountedFrom(members_[product], origin_degC - best);
}

}  // namespace gyrobench::calibration
