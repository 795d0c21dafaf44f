#include "calibration/gls/white_store.h"

#include <cassert>
#include <cmath>
#include <utility>

#include "calibration/gls/filled_columns.h"
#include "calibration/gls/interval_gls.h"
#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {
// Gram-Schmidt on products, column by column: what is left of each after those before it.
class WhiteStore::Elimination {
 public:
  Elimination(const WhiteStore& store, std::span<const Eigen::Index> columns)
      : store_(store),
        lower_(static_cast<Eigen::Index>(columns.size()),
               static_cast<Eigen::Index>(columns.size())) {
    for (std::size_t k = 0; k < columns.size(); ++k) {
      if (Keep(columns[k] + 1)) kept_places_.push_back(static_cast<Eigen::Index>(k));
    }
  }

  // Square of what is left of the column at `place` of the store.
  double Left(Eigen::Index place) const {
    Eigen::VectorXd row;
    const double left = Left(place, &row);
    return left < 0.0 ? 0.0 : left;  // rounding; what is not a number stays none
  }
  // Places in the store of those that do not depend on the ones before them.
  const std::vector<Eigen::Index>& kept() const { return kept_; }
  // The same as places among the columns that were given.
  const std::vector<Eigen::Index>& kept_places() const { return kept_places_; }

 private:
  // `row`: its coordinates along the kept ones.
  double Left(Eigen::Index column, Eigen::VectorXd* row) const {
    const auto kept = static_cast<Eigen::Index>(kept_.size());
    row->resize(kept);
    double left = store_.Product(column, column);
    for (Eigen::Index k = 0; k < kept; ++k) {
      const double product = store_.Product(column, kept_[static_cast<std::size_t>(k)]);
      (*row)(k) = (product - row->head(k).dot(lower_.row(k).head(k))) / lower_(k, k);
      left -= (*row)(k) * (*row)(k);
    }
    return left;
  }
  bool Keep(Eigen::Index column) {
    Eigen::VectorXd row;
    const double left = Left(column, &row), whole = store_.Product(column, column);
    if (!(left > kDependent * whole) || !(whole > 0)) return false;
    const auto kept = static_cast<Eigen::Index>(kept_.size());
    lower_.row(kept).head(kept) = row;
    lower_(kept, kept) = std::sqrt(left);
    kept_.push_back(column);
    return true;
  }

  const WhiteStore& store_;
  Eigen::MatrixXd lower_;
  std::vector<Eigen::Index> kept_, kept_places_;
};

WhiteStore::WhiteStore(const Eigen::VectorXd& output, Eigen::Index capacity)
    : white_(output.size(), capacity + 1),
      more_(static_cast<std::size_t>(capacity + 1)),
      gram_(capacity + 1, capacity + 1),
      known_(Known::Constant(capacity + 1, capacity + 1, false)) {
  white_.col(0) = output;
}

Eigen::Ref<Eigen::MatrixXd> WhiteStore::Places(Eigen::Index count) {
  const Eigen::Index first = used_ + 1;
  if (first + count > white_.cols()) {
    const Eigen::Index size = 2 * (first + count);
    white_.conservativeResize(Eigen::NoChange, size);
    more_.resize(static_cast<std::size_t>(size));
    gram_.conservativeResize(size, size);
    Known known = Known::Constant(size, size, false);
    known.topLeftCorner(first, first) = known_.topLeftCorner(first, first);
    known_ = std::move(known);
  }
  for (Eigen::Index place = first; place < first + count; ++place)
    more_[static_cast<std::size_t>(place)].resize(0);
  known_.middleCols(first, count).setConstant(false);
  known_.middleRows(first, count).setConstant(false);
  return white_.middleCols(first, count);
}

WhiteStore::Columns WhiteStore::Add(const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  Places(columns.cols()) = columns;
  return Add(columns.cols());
}

WhiteStore::Columns WhiteStore::Add(Eigen::Index count) {
  Columns out;
  for (Eigen::Index j = 0; j < count; ++j) out.push_back(used_ + j);
  used_ += count;
  return out;
}

void WhiteStore::SetMoreOfOutput(Eigen::VectorXd more) {
  more_[0] = std::move(more);
  known_.row(0).setConstant(false);
  known_.col(0).setConstant(false);
}

void WhiteStore::SetMore(const Columns& columns, const Eigen::MatrixXd& more) {
  for (std::size_t j = 0; j < columns.size(); ++j) {
    const Eigen::Index place = columns[j] + 1;
    more_[static_cast<std::size_t>(place)] = more.col(static_cast<Eigen::Index>(j));
    known_.row(place).setConstant(false);
    known_.col(place).setConstant(false);
  }
}

double WhiteStore::ProductOfMore(Eigen::Index i, Eigen::Index j) const {
  const Eigen::VectorXd& a = more_[static_cast<std::size_t>(i)];
  const Eigen::VectorXd& b = more_[static_cast<std::size_t>(j)];
  return a.size() > 0 && b.size() > 0 ? a.dot(b) : 0.0;
}

Eigen::VectorXd WhiteStore::MoreOfResidual(std::span<const Eigen::Index> model) const {
  Eigen::VectorXd out = more_[0];
  const Eigen::VectorXd coefficients = Solve(model);
  for (std::size_t j = 0; j < model.size(); ++j) {
    const Eigen::VectorXd& more = more_[static_cast<std::size_t>(model[j] + 1)];
    if (more.size() > 0 && out.size() > 0) out -= coefficients(static_cast<Eigen::Index>(j)) * more;
  }
  return out;
}

void WhiteStore::MultiplyFirst(Eigen::Index count) { Multiply(0, count + 1, 0, used_ + 1); }

void WhiteStore::MultiplyEachOther(const Columns& columns) {
  if (columns.empty()) return;
  assert(columns.back() - columns.front() + 1 == static_cast<Eigen::Index>(columns.size()));
  Multiply(columns.front() + 1, columns.back() + 2, columns.front() + 1, columns.back() + 2);
}

void WhiteStore::Multiply(Eigen::Index row, Eigen::Index row_end, Eigen::Index column,
                          Eigen::Index column_end) {
  const Eigen::Index rows = row_end - row, columns = column_end - column;
  gram_.block(row, column, rows, columns) =
      TransposeTimes(white_.middleCols(row, rows), white_.middleCols(column, columns));
  for (Eigen::Index i = row; i < row_end; ++i) {
    for (Eigen::Index j = column; j < column_end; ++j) gram_(i, j) += ProductOfMore(i, j);
  }
  gram_.block(column, row, columns, rows) =
      gram_.block(row, column, rows, columns).transpose().eval();
  known_.block(row, column, rows, columns).setConstant(true);
  known_.block(column, row, columns, rows).setConstant(true);
}

double WhiteStore::Product(Eigen::Index i, Eigen::Index j) const {
  if (!known_(i, j)) {
    gram_(i, j) = gram_(j, i) = white_.col(i).dot(white_.col(j)) + ProductOfMore(i, j);
    known_(i, j) = known_(j, i) = true;
  }
  return gram_(i, j);
}

Eigen::MatrixXd WhiteStore::Products(const std::vector<Eigen::Index>& rows,
                                     const std::vector<Eigen::Index>& columns) const {
  Eigen::MatrixXd out(static_cast<Eigen::Index>(rows.size()),
                      static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) {
    for (std::size_t i = 0; i < rows.size(); ++i)
      out(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
          Product(rows[i], columns[j]);
  }
  return out;
}

Eigen::MatrixXd WhiteStore::Take(std::span<const Eigen::Index> columns, Eigen::Index first,
                                 Eigen::Index count) const {
  Eigen::MatrixXd out(count, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    out.col(static_cast<Eigen::Index>(j)) = column(columns[j]).segment(first, count);
  return out;
}

Eigen::MatrixXd WhiteStore::Products(std::span<const Eigen::Index> columns) const {
  std::vector<Eigen::Index> places;
  for (const Eigen::Index column : columns) places.push_back(column + 1);
  return Products(places, places);
}

WhiteStore::Fit WhiteStore::FitTo(std::span<const Eigen::Index> columns) const {
  const Elimination elimination(*this, columns);
  return {elimination.Left(0), static_cast<int>(elimination.kept().size())};
}

Eigen::VectorXd WhiteStore::Solve(std::span<const Eigen::Index> columns) const {
  const Elimination elimination(*this, columns);
  const std::vector<Eigen::Index>& kept = elimination.kept();
  Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(columns.size()));
  coefficients(elimination.kept_places()) =
      ScaledLdlt(Products(kept, kept)).Solve(Eigen::VectorXd(Products(kept, {0})));
  return coefficients;
}

WhiteStore::Remainder WhiteStore::RemainderOf(const Columns& columns,
                                              std::span<const Eigen::Index> model) const {
  const Elimination elimination(*this, model);
  const std::vector<Eigen::Index>& kept = elimination.kept();
  std::vector<Eigen::Index> wanted;
  for (const Eigen::Index column : columns) wanted.push_back(column + 1);
  const ScaledLdlt factor(Products(kept, kept));
  const Eigen::MatrixXd shared = Products(kept, wanted);
  const Eigen::VectorXd output = Products(kept, {0});
  Remainder out;
  out.products = Products(wanted, wanted) - shared.transpose() * factor.Solve(shared);
  out.with_output = Products(wanted, {0}) - shared.transpose() * factor.Solve(output);
  return out;
}

double WhiteStore::Left(Eigen::Index column, std::span<const Eigen::Index> model) const {
  const double whole = Product(column + 1, column + 1);
  return whole > 0 ? Elimination(*this, model).Left(column + 1) / whole : 0.0;
}

}  // namespace gyrobench::calibration
