// From which temperature a product is counted.
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <optional>
#include <utility>

#include "calibration/trace/likelihood.h"
#include "calibration/trace/scaled_ldlt.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// Of the square of a column, not in the span of others: it does what they do.
constexpr double kSameSpan = 1e-3;

bool HasTemperature(const Candidate& candidate) {
  return std::ranges::count(candidate.factors, "T") > 0 && candidate.knots.empty();
}

Candidate CountedFrom(const Candidate& product, double lower_by_degC) {
  Candidate out = product;
  for (std::size_t f = 0; f < out.factors.size(); ++f) {
    if (out.factors[f] == "T") out.offsets[f] -= lower_by_degC;
  }
  out.raw.reset();
  out.columns.clear();
  return out;
}

// What white columns explain of an output, the rest of the model taken off both.
double Explained(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output) {
  return ScaledLdlt(columns.transpose() * columns).Square(columns.transpose() * output);
}

}  // namespace

// f (T - T0) beside a part of f alone is f counted from another temperature: one cause where that
// temperature is among those of the data, and where the part has more coefficients, they agree.
void Selection::JoinOrigins() {
  for (std::size_t i = 0; i < members_.size(); ++i) {
    if (!HasTemperature(members_[i])) continue;
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
  const Eigen::MatrixXd whole = store_.Take(members_[product].columns);
  const Eigen::MatrixXd shift = White(CountedFrom(members_[product], 1.0)) - whole;
  const Eigen::MatrixXd plain = store_.Take(members_[part].columns);
  if (!((Projection(shift).Off(plain).colwise().squaredNorm().array() <=
         kSameSpan * plain.colwise().squaredNorm().array())
            .all()))
    return std::nullopt;
  WhiteStore::Columns others = ModelWithout(part);
  std::erase_if(others, [&](Eigen::Index column) {
    return std::ranges::count(members_[product].columns, column) > 0;
  });
  const Projection others_off(store_.Take(others));
  const Eigen::VectorXd output = others_off.Off(store_.output());
  const Eigen::MatrixXd whole_off = others_off.Off(whole), shift_off = others_off.Off(shift);
  Eigen::MatrixXd both(store_.rows(), whole.cols() + plain.cols());
  both << whole_off, others_off.Off(plain);
  auto left = [&](double lower_by_degC) {
    return -Explained(whole_off + lower_by_degC * shift_off, output);
  };
  const double origin_degC = members_[product].offsets[static_cast<std::size_t>(
      std::ranges::find(members_[product].factors, "T") - members_[product].factors.begin())];
  constexpr int kCells = 24, kBits = 20;
  const double low = origin_degC - problem_->max_temperature_degC();
  const double width =
      (problem_->max_temperature_degC() - problem_->min_temperature_degC()) / kCells;
  std::pair<double, double> best = {0.0, left(0.0)};
  for (int cell = 0; cell < kCells; ++cell) {
    const double from = low + cell * width;
    const std::pair<double, double> here =
        boost::math::tools::brent_find_minima(left, from, from + width, kBits);
    if (here.second < best.second) best = here;
  }
  const double lost = Explained(both, output) + best.second;
  const auto freedom = static_cast<double>(plain.cols() - 1);
  if (LogChiSquareTail(lost, std::max(freedom, 1.0)) < members_[part].log_level)
    return std::nullopt;
  Candidate joined = CountedFrom(members_[product], best.first);
  return joined;
}

}  // namespace gyrobench::calibration
