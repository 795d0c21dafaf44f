// Normal equations of a chain of nodes that share some parameters.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace gyrobench::calibration {

// Least squares over nodes 0 .. n - 1, each of `kNode` unknowns, and `parameters` more that all of
// them feel. What is measured touches one node or two neighbours, so that the matrix is block
// tridiagonal with a border ("arrow"); nodes are eliminated one after the other in O(n).
class ArrowSystem {
 public:
  static constexpr Eigen::Index kNode = 11;

  // Products of some rows: [J r]^T [J r] over the columns (node, parameters, residual), or (node,
  // next node, parameters, residual); without the parameters where the rows do not feel them.
  using Products = Eigen::MatrixXd;

  struct Solution {
    std::vector<Eigen::Matrix<double, kNode, 1>> nodes;
    Eigen::VectorXd parameters;
    // Of the parameters, then of the functionals.
    Eigen::MatrixXd covariance;
    double residual_square = 0.0;  // weighted, at the minimum
    double log_determinant = 0.0;  // of the whole matrix
    bool positive = false;         // false: something is not determined; the rest is not valid
  };

  // `functionals`: sums over the nodes' unknowns whose covariance is asked for.
  ArrowSystem(Eigen::Index nodes, Eigen::Index parameters, Eigen::Index functionals = 0);
  void AddNode(Eigen::Index node, const Products& products, double weight);
  void AddPair(Eigen::Index first, const Products& products, double weight);
  // weight (p_i - value)^2, value counted from where the system is linearised.
  void AddParameter(Eigen::Index i, double value, double weight);
  // Functional f has `weight` times unknown `i` of the node as one of its summands.
  void AddSummand(Eigen::Index f, Eigen::Index node, Eigen::Index i, double weight);
  // The values that minimise; the system is used up.
  Solution Solve();

 private:
  void AddShared(Eigen::Index node, const Products& products, Eigen::Index shared, Eigen::Index at,
                 double weight);
  void AddCorner(const Products& products, Eigen::Index shared, double weight);

  Eigen::Index p_, f_;
  // Of each node: columns (itself, next, parameters, right-hand side, functionals).
  std::vector<Eigen::MatrixXd> rows_;
  Eigen::MatrixXd corner_;  // columns (parameters, right-hand side, functionals)
  double square_ = 0.0;
};

}  // namespace gyrobench::calibration
