// The temperature, or the value of a covariate, from which a product is counted.
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "calibration/effects/factor.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/refine.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Share of a column's square outside the span of others below which it does what they do.
constexpr double kSameSpan = 1e-3;

Candidate CountedFrom(const Candidate& product, const Origin& origin, double zero) {
  Candidate out = product;
  out.origin = origin;
  SetNonlinear({zero}, &out);
  out.columns.clear();
  return out;
}

Origin RangeOf(const ChannelProblem& problem, const std::string& name,
               const std::vector<std::string>& covariates) {
  const Factor factor = *Factor::Make(name, problem.channel(), covariates);
  Origin out{name, kMissing, kMissing};
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    for (const std::size_t half : {0u, 1u}) {
      const double value = factor.At(problem.half(i, half));
      out.low = std::fmin(out.low, value);
      out.high = std::fmax(out.high, value);
    }
  }
  return out;
}

// The zero of a square is in both of its factors.
bool HasSquare(const Candidate& product) {
  for (std::size_t f = 0; f + 1 < product.factors.size(); f += 2) {
    if (product.factors[f] == product.factors[f + 1]) return true;
  }
  return false;
}

// The quantities of a product whose zero is a convention. Those of rate and gravity are physics.
std::vector<Origin> OriginsOf(const ChannelProblem& problem, const Candidate& candidate,
                              const std::vector<std::string>& covariates) {
  if (candidate.effect != nullptr || candidate.empirical() || HasSquare(candidate)) return {};
  if (candidate.origin) return {*candidate.origin};
  std::vector<Origin> out;
  for (const std::string& factor : candidate.factors) {
    const bool countable = factor == "T" || std::ranges::count(covariates, factor) > 0;
    if (!countable || std::ranges::count(out, factor, &Origin::of) > 0) continue;
    out.push_back(RangeOf(problem, factor, covariates));
  }
  return out;
}

bool InSpan(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& of) {
  const Eigen::VectorXd outside = Projection(of).Off(columns).colwise().squaredNorm();
  const Eigen::VectorXd squares = columns.colwise().squaredNorm();
  return (outside.array() <= kSameSpan * squares.array()).all();
}

// The gain of f (q - q0) for any q0, from products of f (q - q00), f and the output.
class GainByOrigin {
 public:
  GainByOrigin(const Eigen::MatrixXd& product, const Eigen::MatrixXd& factor,
               const Eigen::VectorXd& output)
      : products_(product.transpose() * product),
        mixed_(product.transpose() * factor + factor.transpose() * product),
        factors_(factor.transpose() * factor),
        with_product_(product.transpose() * output),
        with_factor_(factor.transpose() * output) {}

  double At(double lower_by) const {
    return ScaledLdlt(products_ + lower_by * mixed_ + lower_by * lower_by * factors_)
        .Square(with_product_ + lower_by * with_factor_);
  }

 private:
  Eigen::MatrixXd products_, mixed_, factors_;
  Eigen::VectorXd with_product_, with_factor_;
};

}  // namespace

// f (q - q0) is the sum of f q and a part of f alone, whatever the quantity q is counted from. The
// two are one cause where the data have the value q0, and where f has several terms and all parts
// agree in it.
void Selection::JoinOrigins() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    for (const Origin& origin : OriginsOf(*problem_, members_[i], covariates())) {
      const std::size_t part = JoinOne(i, origin);
      if (part == kNoMember) continue;
      if (part < i) --i;
      break;
    }
  }
}

// The member that is in the product now.
std::size_t Selection::JoinOne(std::size_t product, const Origin& origin) {
  for (std::size_t j = 0; j < members_.size(); ++j) {
    if (members_[j].effect == nullptr || members_[j].effect->true_motion) continue;
    std::optional<Candidate> joined = Joined(product, j, origin);
    if (!joined) continue;
    joined->columns = store_.Add(White(*joined));
    members_[product] = std::move(*joined);
    Remove(j);
    return j;
  }
  return kNoMember;
}

std::optional<Candidate> Selection::Joined(std::size_t product, std::size_t part,
                                           const Origin& origin) const {
  const Candidate& member = members_[product];
  const auto counted = std::ranges::find(member.factors, origin.of);
  const double zero = member.offsets[static_cast<std::size_t>(counted - member.factors.begin())];
  const Eigen::MatrixXd whole = store_.Take(member.columns);
  const Eigen::MatrixXd factor = White(CountedFrom(member, origin, zero - 1.0)) - whole;
  const Eigen::MatrixXd plain = store_.Take(members_[part].columns);
  // A product with gravity along one axis is a part of a sensitivity along all three.
  if (!InSpan(plain, factor) && !InSpan(factor, plain)) return std::nullopt;
  WhiteStore::Columns others = ModelWithout(part);
  std::erase_if(
      others, [&](Eigen::Index column) { return std::ranges::count(member.columns, column) > 0; });
  const Projection others_off(store_.Take(others));
  const Eigen::VectorXd output = others_off.Off(store_.output());
  const Eigen::MatrixXd whole_off = others_off.Off(whole), factor_off = others_off.Off(factor);
  const GainByOrigin gain(whole_off, factor_off, output);
  constexpr int kCells = 24, kBits = 20;
  const double low = zero - origin.high;
  const double width = (origin.high - origin.low) / kCells;
  double best = 0.0, least = std::numeric_limits<double>::infinity();
  for (int cell = 0; cell < kCells; ++cell) {
    const auto [at, minus_gain] =
        boost::math::tools::brent_find_minima([&](double lower_by) { return -gain.At(lower_by); },
                                              low + cell * width, low + (cell + 1) * width, kBits);
    if (!(minus_gain < least)) continue;
    least = minus_gain;
    best = at;
  }
  Eigen::MatrixXd both(store_.rows(), whole.cols() + plain.cols());
  both << whole_off, others_off.Off(plain);
  const double together = ScaledLdlt(both.transpose() * both).Square(both.transpose() * output);
  // Of what the part can do beside the product one number is left.
  const int lost = store_.FitTo(ModelColumns()).rank - store_.FitTo(ModelWithout(part)).rank - 1;
  const double freedom = std::max(lost, 1);
  if (LogChiSquareTail(together + least, freedom) < members_[part].log_level) return std::nullopt;
  return CountedFrom(member, origin, zero - best);
}

}  // namespace gyrobench::calibration
