#include "tests/calibration/dense_gls.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace gyrobench::testing {
namespace {

// Double integral of min(u, v) over [a, b] x [c, d], two intervals that are the same or do not
// overlap.
double IntegralOfMin(double a, double b, double c, double d) {
  if (a == c && b == d) return a * (b - a) * (b - a) + std::pow(b - a, 3) / 3.0;
  return b <= c ? 0.5 * (b * b - a * a) * (d - c) : 0.5 * (d * d - c * c) * (b - a);
}

int SharedSign(const DenseInterval& a, const DenseInterval& b) {
  int sign = 0;
  for (const auto& [angle_a, sign_a] : {std::pair{a.begin_angle, 1}, std::pair{a.end_angle, -1}}) {
    for (const auto& [angle_b, sign_b] :
         {std::pair{b.begin_angle, 1}, std::pair{b.end_angle, -1}}) {
      if (angle_a >= 0 && angle_a == angle_b) sign += sign_a * sign_b;
    }
  }
  return sign;
}

}  // namespace

Eigen::MatrixXd DenseCovariance(const std::vector<DenseInterval>& intervals,
                                const DenseNoise& noise) {
  const auto n = static_cast<Eigen::Index>(intervals.size());
  const double start_s = intervals.front().begin_s;
  Eigen::MatrixXd v(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const DenseInterval& a = intervals[static_cast<std::size_t>(i)];
      const DenseInterval& b = intervals[static_cast<std::size_t>(j)];
      v(i, j) = noise.k * noise.k *
                    IntegralOfMin(a.begin_s - start_s, a.end_s - start_s, b.begin_s - start_s,
                                  b.end_s - start_s) +
                noise.s * noise.s * SharedSign(a, b);
      if (i == j) v(i, j) += noise.n * noise.n * (a.end_s - a.begin_s);
    }
  }
  return v;
}

DenseSolution SolveDense(const Eigen::MatrixXd& v, const Eigen::MatrixXd& x,
                         const Eigen::VectorXd& y) {
  const Eigen::LLT<Eigen::MatrixXd> factor(v);
  const Eigen::MatrixXd vx = factor.solve(x);
  const Eigen::MatrixXd information = x.transpose() * vx;
  const Eigen::LLT<Eigen::MatrixXd> inner(information);
  DenseSolution out;
  out.coefficients = inner.solve(vx.transpose() * y);
  out.covariance = inner.solve(Eigen::MatrixXd::Identity(x.cols(), x.cols()));
  const Eigen::VectorXd r = y - x * out.coefficients;
  const double log_det_v = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  const double log_det_x = 2.0 * inner.matrixLLT().diagonal().array().log().sum();
  out.deviance = log_det_v + r.dot(factor.solve(r));
  out.restricted_deviance = out.deviance + log_det_x;
  return out;
}

}  // namespace gyrobench::testing
