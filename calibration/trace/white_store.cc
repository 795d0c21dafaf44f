#include "calibration/trace/white_store.h"

#include <algorithm>
#include <cmath>

#include "calibration/trace/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

constexpr double kDependent = 1e-9;
// Columns whose products with those after them are worked out at once.
constexpr Eigen::Index kPanel = 24;

// Gram-Schmidt on products, column by column: what is left of each after those before it.
class Elimination {
 public:
  Elimination(const Eigen::MatrixXd& gram, Eigen::Index size) : gram_(gram), lower_(size, size) {}

  // Square of what is left of `column`; its coordinates along the kept ones go to `row`.
  double Left(Eigen::Index column, Eigen::VectorXd* row) const {
    const auto kept = static_cast<Eigen::Index>(kept_.size());
    row->resize(kept);
    double left = gram_(column, column);
    for (Eigen::Index k = 0; k < kept; ++k) {
      const double product = gram_(column, kept_[static_cast<std::size_t>(k)]);
      (*row)(k) = (product - row->head(k).dot(lower_.row(k).head(k))) / lower_(k, k);
      left -= (*row)(k) * (*row)(k);
    }
    return left;
  }
  bool Keep(Eigen::Index column) {
    Eigen::VectorXd row;
    const double left = Left(column, &row);
    if (!(left > kDependent * gram_(column, column)) || !(gram_(column, column) > 0)) return false;
    const auto kept = static_cast<Eigen::Index>(kept_.size());
    lower_.row(kept).head(kept) = row;
    lower_(kept, kept) = std::sqrt(left);
    kept_.push_back(column);
    return true;
  }
  const std::vector<Eigen::Index>& kept() const { return kept_; }

 private:
  const Eigen::MatrixXd& gram_;
  Eigen::MatrixXd lower_;
  std::vector<Eigen::Index> kept_;
};

}  // namespace

WhiteStore::WhiteStore(const Eigen::VectorXd& output, Eigen::Index capacity)
    : white_(output.size(), capacity + 1), gram_(capacity + 1, capacity + 1) {
  white_.col(0) = output;
  gram_(0, 0) = output.squaredNorm();
}

Eigen::Ref<Eigen::MatrixXd> WhiteStore::Places(Eigen::Index count) {
  const Eigen::Index first = used_ + 1;
  if (first + count > white_.cols()) {
    const Eigen::Index size = 2 * (first + count);
    white_.conservativeResize(Eigen::NoChange, size);
    gram_.conservativeResize(size, size);
  }
  return white_.middleCols(first, count);
}

WhiteStore::Columns WhiteStore::Add(const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  Places(columns.cols()) = columns;
  return Add(columns.cols());
}

WhiteStore::Columns WhiteStore::Add(Eigen::Index count) {
  const Eigen::Index first = used_ + 1;
  const Eigen::Index end = first + count, top = std::min(end, std::max(first, kPanel));
  const auto products = [&](Eigen::Index row, Eigen::Index row_end, Eigen::Index column,
                            Eigen::Index column_end) {
    gram_.block(row, column, row_end - row, column_end - column).noalias() =
        white_.middleCols(row, row_end - row).transpose() *
        white_.middleCols(column, column_end - column);
  };
  // Of many columns with each other what lies below the diagonal is enough.
  Eigen::Index column = first;
  for (; end - column >= 2 * kPanel; column += kPanel)
    products(column - first, end, column, column + kPanel);
  products(0, end, column, end);
  if (column > first) products(0, top, first, column);
  for (Eigen::Index j = first; j < column; ++j)
    gram_.col(j).segment(top, std::max(j - top, Eigen::Index{0})) =
        gram_.row(j).segment(top, std::max(j - top, Eigen::Index{0}));
  gram_.block(first, 0, count, first) = gram_.block(0, first, first, count).transpose();
  Columns out;
  for (Eigen::Index j = 0; j < count; ++j) out.push_back(used_ + j);
  used_ += count;
  return out;
}

Eigen::MatrixXd WhiteStore::Take(std::span<const Eigen::Index> columns) const {
  Eigen::MatrixXd out(rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    out.col(static_cast<Eigen::Index>(j)) = column(columns[j]);
  return out;
}

WhiteStore::Fit WhiteStore::FitTo(std::span<const Eigen::Index> columns) const {
  Elimination elimination(gram_, static_cast<Eigen::Index>(columns.size()));
  for (const Eigen::Index column : columns) elimination.Keep(column + 1);
  Eigen::VectorXd row;
  const double left = elimination.Left(0, &row);
  return {std::fmax(left, 0.0), static_cast<int>(elimination.kept().size())};
}

Eigen::VectorXd WhiteStore::Solve(std::span<const Eigen::Index> columns) const {
  const auto p = static_cast<Eigen::Index>(columns.size());
  Elimination elimination(gram_, p);
  std::vector<Eigen::Index> place;
  for (Eigen::Index j = 0; j < p; ++j) {
    if (elimination.Keep(columns[static_cast<std::size_t>(j)] + 1)) place.push_back(j);
  }
  const std::vector<Eigen::Index>& kept = elimination.kept();
  const Eigen::VectorXd right = gram_.col(0)(kept);
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(p);
  coefficients(place) = ScaledLdlt(gram_(kept, kept)).Solve(right);
  return coefficients;
}

WhiteStore::Remainder WhiteStore::RemainderOf(const Columns& columns,
                                              std::span<const Eigen::Index> model) const {
  Elimination elimination(gram_, static_cast<Eigen::Index>(model.size()));
  for (const Eigen::Index column : model) elimination.Keep(column + 1);
  const std::vector<Eigen::Index>& kept = elimination.kept();
  std::vector<Eigen::Index> wanted;
  for (const Eigen::Index column : columns) wanted.push_back(column + 1);
  const ScaledLdlt factor(gram_(kept, kept));
  const Eigen::MatrixXd shared = gram_(kept, wanted);
  const Eigen::VectorXd output = gram_.col(0)(kept);
  Remainder out;
  out.products = Eigen::MatrixXd(gram_(wanted, wanted)) - shared.transpose() * factor.Solve(shared);
  out.with_output =
      Eigen::VectorXd(gram_.col(0)(wanted)) - shared.transpose() * factor.Solve(output);
  return out;
}

double WhiteStore::Left(Eigen::Index column, std::span<const Eigen::Index> model) const {
  Elimination elimination(gram_, static_cast<Eigen::Index>(model.size()));
  for (const Eigen::Index member : model) elimination.Keep(member + 1);
  Eigen::VectorXd row;
  const double whole = gram_(column + 1, column + 1);
  return whole > 0 ? std::fmax(elimination.Left(column + 1, &row), 0.0) / whole : 0.0;
}

}  // namespace gyrobench::calibration
