// The most that coefficients of a limited length explain, against a search over all directions.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::testing {
namespace {

using calibration::GainOfLength;

constexpr double kLeast = 1e-9;

// Directions of a sphere, and along each the best length up to the longest.
double BestOfAll(const Eigen::Matrix3d& gram, const Eigen::Vector3d& scores, double longest) {
  constexpr int kSteps = 400;
  double best = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j < 2 * kSteps; ++j) {
      const double theta = M_PI * i / kSteps, phi = M_PI * j / kSteps;
      const Eigen::Vector3d u(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                              std::cos(theta));
      const double square = u.dot(gram * u), along = scores.dot(u);
      const double length = square > 0.0 ? std::clamp(along / square, 0.0, longest) : longest;
      best = std::max(best, 2.0 * along * length - square * length * length);
    }
  }
  return best;
}

Eigen::Matrix3d SomeGram() {
  Eigen::Matrix3d a;
  a << 3.0, 0.4, -0.2, 0.1, 2.0, 0.5, -0.3, 0.2, 1.2;
  return a.transpose() * a;
}

TEST(GainOfLength, IsTheMostOfAllDirections) {
  const Eigen::Matrix3d gram = SomeGram();
  const Eigen::Vector3d scores(1.0, -2.0, 0.7);
  const double free = gram.ldlt().solve(scores).norm();
  for (const double share : {0.01, 0.3, 0.99, 1.01, 10.0}) {
    const auto found = GainOfLength(gram, scores, kLeast, share * free);
    const double all = BestOfAll(gram, scores, share * free);
    EXPECT_NEAR(found.gain, all, 1e-3 * all) << share;
    EXPECT_GE(found.gain, all * (1.0 - 1e-9)) << share;
    EXPECT_EQ(found.rank, 3);
  }
}

TEST(GainOfLength, IsThatOfTheLeastSquaresWhereItIsShortEnough) {
  const Eigen::Matrix3d gram = SomeGram();
  const Eigen::Vector3d scores(0.3, 0.2, -0.5);
  const Eigen::Vector3d free = gram.ldlt().solve(scores);
  const double all = scores.dot(free);
  EXPECT_NEAR(GainOfLength(gram, scores, kLeast, 2.0 * free.norm()).gain, all, 1e-9 * all);
}

// What the data do not know neither gains nor counts.
TEST(GainOfLength, LeavesOutWhatIsNotKnown) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1.0, 2.0, -2.0) / 3.0;
  const Eigen::Matrix3d gram = 4.0 * axis * axis.transpose();
  const auto found = GainOfLength(gram, 6.0 * axis, kLeast, 100.0);
  EXPECT_NEAR(found.gain, 9.0, 1e-9);
  EXPECT_EQ(found.rank, 1);
  const auto nothing = GainOfLength(Eigen::Matrix3d::Zero(), Eigen::Vector3d::Zero(), kLeast, 1.0);
  EXPECT_EQ(nothing.gain, 0.0);
  EXPECT_EQ(nothing.rank, 0);
}

}  // namespace
}  // namespace gyrobench::testing
