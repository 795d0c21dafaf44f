#include "calibration/hold/arrow_system.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstddef>

namespace gyrobench::calibration {

using Eigen::Index;
using Eigen::MatrixXd;

namespace {

double LogDeterminant(const Eigen::LLT<MatrixXd>& factor) {
  double sum = 0.0;
  for (Index i = 0; i < factor.matrixLLT().rows(); ++i)
    sum += 2.0 * std::log(factor.matrixLLT()(i, i));
  return sum;
}

}  // namespace

ArrowSystem::ArrowSystem(Index nodes, Index parameters, Index functionals)
    : p_(parameters),
      f_(functionals),
      rows_(static_cast<std::size_t>(nodes),
            MatrixXd::Zero(kNode, 2 * kNode + parameters + 1 + functionals)),
      corner_(MatrixXd::Zero(parameters, parameters + 1 + functionals)) {}

void ArrowSystem::AddNode(Index node, const Products& products, double weight) {
  MatrixXd& row = rows_[static_cast<std::size_t>(node)];
  row.leftCols(kNode) += weight * products.topLeftCorner(kNode, kNode);
  AddShared(node, products, kNode, 0, weight);
  AddCorner(products, kNode, weight);
}

void ArrowSystem::AddPair(Index first, const Products& products, double weight) {
  rows_[static_cast<std::size_t>(first)].leftCols(2 * kNode) +=
      weight * products.topLeftCorner(kNode, 2 * kNode);
  rows_[static_cast<std::size_t>(first + 1)].leftCols(kNode) +=
      weight * products.block(kNode, kNode, kNode, kNode);
  AddShared(first, products, 2 * kNode, 0, weight);
  AddShared(first + 1, products, 2 * kNode, kNode, weight);
  AddCorner(products, 2 * kNode, weight);
}

// Columns of the parameters, if there are any, and of the right-hand side, of a node whose own rows
// begin at `at`.
void ArrowSystem::AddShared(Index node, const Products& products, Index shared, Index at,
                            double weight) {
  MatrixXd& row = rows_[static_cast<std::size_t>(node)];
  const Index parameters = products.cols() - 1 - shared;
  if (parameters > 0)
    row.middleCols(2 * kNode, parameters) += weight * products.block(at, shared, kNode, parameters);
  row.col(2 * kNode + p_) += weight * products.col(shared + parameters).segment(at, kNode);
}

void ArrowSystem::AddCorner(const Products& products, Index shared, double weight) {
  const Index parameters = products.cols() - 1 - shared;
  if (parameters > 0)
    corner_.leftCols(parameters + 1) +=
        weight * products.block(shared, shared, parameters, parameters + 1);
  square_ += weight * products(shared + parameters, shared + parameters);
}

void ArrowSystem::AddSummand(Index f, Index node, Index i, double weight) {
  rows_[static_cast<std::size_t>(node)](i, 2 * kNode + p_ + 1 + f) += weight;
}

void ArrowSystem::AddParameter(Index i, double value, double weight) {
  corner_(i, i) += weight;
  corner_(i, p_) -= weight * value;
  square_ += weight * value * value;
}

// With H the matrix and c = J^T r, the minimum of |J x + r|^2 is at x = -H^-1 c; of the
// functionals' coefficients L the covariance is L^T H^-1 L, and H^-1 L with the parameters.
ArrowSystem::Solution ArrowSystem::Solve() {
  Solution out;
  const Index right = p_ + 1 + f_;
  MatrixXd functionals = MatrixXd::Zero(f_, f_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    MatrixXd& row = rows_[k];
    const Eigen::LLT<MatrixXd> factor(row.leftCols(kNode));
    if (factor.info() != Eigen::Success) return out;
    out.log_determinant += LogDeterminant(factor);
    const MatrixXd solved = factor.solve(row.rightCols(kNode + right));
    corner_.noalias() -= row.middleCols(2 * kNode, p_).transpose() * solved.rightCols(right);
    square_ -= row.col(2 * kNode + p_).dot(solved.col(kNode + p_));
    functionals.noalias() += row.rightCols(f_).transpose() * solved.rightCols(f_);
    if (k + 1 < rows_.size()) {
      const auto next = row.middleCols(kNode, kNode);
      rows_[k + 1].leftCols(kNode).noalias() -= next.transpose() * solved.leftCols(kNode);
      rows_[k + 1].rightCols(right).noalias() -= next.transpose() * solved.rightCols(right);
    }
    row.rightCols(kNode + right) = solved;
  }
  const Eigen::LLT<MatrixXd> factor(corner_.leftCols(p_));
  if (factor.info() != Eigen::Success) return out;
  out.log_determinant += LogDeterminant(factor);
  out.covariance.resize(p_ + f_, p_ + f_);
  out.covariance.topLeftCorner(p_, p_) = factor.solve(MatrixXd::Identity(p_, p_));
  if (f_ > 0) {  // Eigen solves nothing of size 0
    const MatrixXd across = factor.solve(corner_.rightCols(f_));
    out.covariance.topRightCorner(p_, f_) = across;
    out.covariance.bottomLeftCorner(f_, p_) = across.transpose();
    out.covariance.bottomRightCorner(f_, f_) =
        functionals + corner_.rightCols(f_).transpose() * across;
  }
  out.parameters = -out.covariance.topLeftCorner(p_, p_) * corner_.col(p_);
  out.residual_square = square_ + corner_.col(p_).dot(out.parameters);
  out.nodes.resize(rows_.size());
  for (std::size_t k = rows_.size(); k-- > 0;) {
    const MatrixXd& row = rows_[k];
    out.nodes[k] = -row.col(2 * kNode + p_) - row.middleCols(2 * kNode, p_) * out.parameters;
    if (k + 1 < rows_.size()) out.nodes[k] -= row.middleCols(kNode, kNode) * out.nodes[k + 1];
  }
  out.positive = true;
  return out;
}

}  // namespace gyrobench::calibration
