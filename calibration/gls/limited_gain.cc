#include <Eigen/Eigenvalues>
#include <boost/math/tools/toms748_solve.hpp>
#include <cstdint>

#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {

LimitedGain GainOfLength(const Eigen::MatrixXd& gram, const Eigen::VectorXd& scores, double least,
                         double longest) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  const Eigen::Array<bool, Eigen::Dynamic, 1> known = solver.eigenvalues().array() >= least;
  const Eigen::ArrayXd values = solver.eigenvalues().array().max(least);
  const Eigen::ArrayXd b = known.select((solver.eigenvectors().transpose() * scores).array(), 0.0);
  const auto too_long = [&](double l) { return (b / (values + l)).matrix().norm() - longest; };
  double l = 0.0;
  if (too_long(0.0) > 0.0) {
    constexpr int kBits = 40;
    std::uintmax_t steps = 100;
    // At |b| / longest c is no longer than that whatever G is.
    const auto [low, high] =
        boost::math::tools::toms748_solve(too_long, 0.0, b.matrix().norm() / longest,
                                          boost::math::tools::eps_tolerance<double>(kBits), steps);
    l = 0.5 * (low + high);
  }
  return {(b.square() * (values + 2.0 * l) / (values + l).square()).sum(),
          static_cast<int>(known.count())};
}

}  // namespace gyrobench::calibration
