#include "calibration/gls/stability.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace gyrobench::calibration {
namespace {

constexpr Eigen::Index kBlocks = 40;
constexpr int kHalves = 50;
constexpr double kNearly = 0.8;  // of the best gain of a half
constexpr double kMostHalves = 0.6;

}  // namespace

bool StaysBest(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
               Eigen::Index chosen) {
  const Eigen::Index p = columns.cols(), n = columns.rows();
  Eigen::MatrixXd scores(kBlocks, p), squares(kBlocks, p);
  for (Eigen::Index b = 0; b < kBlocks; ++b) {
    const Eigen::Index begin = n * b / kBlocks, size = n * (b + 1) / kBlocks - begin;
    const auto block = columns.middleRows(begin, size);
    scores.row(b) = residual.segment(begin, size).transpose() * block;
    squares.row(b) = block.colwise().squaredNorm();
  }
  std::mt19937_64 random(1);
  std::vector<Eigen::Index> order(kBlocks);
  std::iota(order.begin(), order.end(), 0);
  int wins = 0;
  for (int half = 0; half < kHalves; ++half) {
    std::shuffle(order.begin(), order.end(), random);
    const std::vector<Eigen::Index> taken(order.begin(), order.begin() + kBlocks / 2);
    const Eigen::RowVectorXd score = scores(taken, Eigen::all).colwise().sum();
    const Eigen::RowVectorXd square = squares(taken, Eigen::all).colwise().sum();
    const Eigen::ArrayXd gain = score.array().square() / square.array().max(1e-300);
    wins += gain(chosen) >= kNearly * gain.maxCoeff() ? 1 : 0;
  }
  return wins > kMostHalves * kHalves;
}

}  // namespace gyrobench::calibration
