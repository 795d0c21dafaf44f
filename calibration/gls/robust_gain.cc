#include "calibration/gls/robust_gain.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

// Sums over blocks of rows; the last block of a run may be shorter.
Eigen::MatrixXd BlockSums(const Eigen::Ref<const Eigen::MatrixXd>& rows, Eigen::Index block) {
  Eigen::MatrixXd out((rows.rows() + block - 1) / block, rows.cols());
  for (Eigen::Index b = 0; b < out.rows(); ++b) {
    const Eigen::Index begin = b * block;
    out.row(b) = rows.middleRows(begin, std::min(block, rows.rows() - begin)).colwise().sum();
  }
  return out;
}

// Columns that do not depend on each other, and what they explain beside a white residual.
struct Explained {
  Explained(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output) {
    const Eigen::MatrixXd gram = columns.transpose() * columns;
    const std::vector<Eigen::Index> kept = IndependentColumns(gram);
    if (kept.empty()) return;
    own = columns(Eigen::all, kept);
    factor = ScaledLdlt(gram(kept, kept));
    right = own.transpose() * output;
    white = {factor.Square(right), static_cast<int>(kept.size())};
  }

  Eigen::MatrixXd own;
  ScaledLdlt factor;      // of their products
  Eigen::VectorXd right;  // their products with the output
  CorrelatedGain white;
};

// Of equal shares that add up as these do.
double NumberOf(const Eigen::VectorXd& shares) {
  return shares.sum() * shares.sum() / shares.squaredNorm();
}

// Nearly as many clusters as rows: none shares anything.
constexpr double kAlone = 0.9;

}  // namespace

CorrelatedGain GainWhereCorrelated(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                                   const Eigen::VectorXd& residual,
                                   const std::vector<Eigen::Index>& run_begins,
                                   Eigen::Index block) {
  const Explained explained(columns, output);
  if (explained.white.rank == 0) return {};
  const Eigen::MatrixXd score = residual.asDiagonal() * explained.own;
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(score.cols(), score.cols());
  for (std::size_t r = 0; r < run_begins.size(); ++r) {
    const Eigen::Index end = r + 1 < run_begins.size() ? run_begins[r + 1] : score.rows();
    const Eigen::MatrixXd sums =
        BlockSums(score.middleRows(run_begins[r], end - run_begins[r]), block);
    spread += sums.transpose() * sums;
    for (Eigen::Index lag = 1; lag < std::min(kCorrelatedBlocks, sums.rows()); ++lag) {
      const double weight = 1.0 - static_cast<double>(lag) / kCorrelatedBlocks;
      const Eigen::MatrixXd shared =
          sums.topRows(sums.rows() - lag).transpose() * sums.bottomRows(sums.rows() - lag);
      spread += weight * (shared + shared.transpose());
    }
  }
  const double gain = ScaledLdlt(spread).Square(explained.right);
  return {std::min(explained.white.gain, gain), explained.white.rank};
}

CorrelatedGain GainWhereClustered(const Eigen::MatrixXd& columns, const Eigen::VectorXd& output,
                                  const Eigen::VectorXd& residual,
                                  const std::vector<std::size_t>& cluster) {
  const Explained explained(columns, output);
  const auto& [own, factor, right, white] = explained;
  if (!(white.gain > 0.0)) return white;
  const Eigen::VectorXd along = own * factor.Solve(right);
  const auto clusters = static_cast<Eigen::Index>(*std::ranges::max_element(cluster) + 1);
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(clusters, own.cols());
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(clusters);
  for (Eigen::Index i = 0; i < own.rows(); ++i) {
    const auto c = static_cast<Eigen::Index>(cluster[static_cast<std::size_t>(i)]);
    sums.row(c) += residual(i) * own.row(i);
    shares(c) += along(i) * along(i);
  }
  const double number = NumberOf(shares), freedom = number - white.rank;
  if (number > kAlone * NumberOf(along.cwiseAbs2()) || !(freedom > 1.0)) return white;
  const double gain = ScaledLdlt(sums.transpose() * sums).Square(right);
  return {std::min(white.gain, freedom * std::log1p(gain / number)), white.rank};
}

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
