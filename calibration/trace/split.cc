#include "calibration/trace/split.h"

#include <algorithm>

#include "calibration/trace/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastBlock_s = 20.0, kMostBlocks = 100.0;
constexpr double kFirstShare = 0.6;
constexpr Eigen::Index kLeastRows = 100;
// A variance that grows by more without some rows: they alone knew.
constexpr double kLostSight = 4.0;
// Place of the rest among three blocks, in turn: what repeats with the blocks must not meet one
// place alone, and no two blocks of the rest lie side by side.
constexpr std::size_t kPlaces[] = {1, 0, 2};

Eigen::VectorXd Variances(const Eigen::MatrixXd& gram) {
  return ScaledLdlt(gram).Solve(Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).diagonal();
}

Eigen::MatrixXd ProductsOf(const Eigen::MatrixXd& columns, const RowRange& range) {
  const auto some = columns.middleRows(range.begin, range.size());
  return some.transpose() * some;
}

// Gives back to training what it cannot do without.
void KeepSight(const Eigen::MatrixXd& columns, RowRanges* rest) {
  const Eigen::MatrixXd all = columns.transpose() * columns;
  Eigen::MatrixXd training = all;
  for (const RowRange& range : *rest) training -= ProductsOf(columns, range);
  const Eigen::VectorXd whole = Variances(all);
  while (!rest->empty()) {
    const Eigen::ArrayXd grown = Variances(training).array() / whole.array();
    // Columns that depend on others have no variance, with or without the rest.
    Eigen::Index worst = -1;
    double most = kLostSight;
    for (Eigen::Index j = 0; j < grown.size(); ++j) {
      const bool lost = whole(j) > 0.0 && (!(grown(j) > 0.0) || grown(j) > most);
      if (!lost) continue;
      worst = j;
      most = grown(j) > 0.0 ? grown(j) : most;
    }
    if (worst < 0) return;
    const auto by_share = [&](const RowRange& a, const RowRange& b) {
      return columns.col(worst).segment(a.begin, a.size()).squaredNorm() <
             columns.col(worst).segment(b.begin, b.size()).squaredNorm();
    };
    const auto most_of_it = std::max_element(rest->begin(), rest->end(), by_share);
    training += ProductsOf(columns, *most_of_it);
    rest->erase(most_of_it);
  }
}

Split Complement(Eigen::Index rows, RowRanges rest) {
  Split out;
  Eigen::Index next = 0;
  for (const RowRange& range : rest) {
    for (; next < range.begin; ++next) out.training.push_back(next);
    next = range.end;
  }
  for (; next < rows; ++next) out.training.push_back(next);
  out.rest = std::move(rest);
  return out;
}

}  // namespace

RowRanges Blocks(const ChannelProblem& problem) {
  RowRanges blocks;
  double time_s = 0.0;
  for (const Interval& interval : problem.intervals()) time_s += interval.duration_s;
  const double block_s = std::max(kLeastBlock_s, time_s / kMostBlocks);
  double filled_s = 0.0;
  Eigen::Index begin = 0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    filled_s += problem.intervals()[static_cast<std::size_t>(i)].duration_s;
    const bool last = i + 1 == problem.rows() || problem.power_on(i + 1) != problem.power_on(i);
    if (filled_s < block_s && !last) continue;
    blocks.push_back({begin, i + 1});
    begin = i + 1;
    filled_s = 0.0;
  }
  return blocks;
}

std::optional<Split> EveryThirdBlock(const ChannelProblem& problem, const Baseline& baseline) {
  RowRanges rest;
  const RowRanges blocks = Blocks(problem);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const bool first =
        i == 0 || problem.power_on(blocks[i].begin) != problem.power_on(blocks[i - 1].begin);
    if (!first && i % 3 == kPlaces[(i / 3) % 3]) rest.push_back(blocks[i]);
  }
  KeepSight(baseline.columns, &rest);
  if (rest.empty()) return std::nullopt;
  return Complement(problem.rows(), std::move(rest));
}

std::optional<Split> FirstPart(const ChannelProblem& problem) {
  if (problem.run_begins().size() != 1 || problem.rows() < kLeastRows) return std::nullopt;
  const double first_s = problem.begin_s(0), last_s = problem.end_s(problem.rows() - 1);
  Eigen::Index split = 0;
  while (problem.end_s(split) < first_s + kFirstShare * (last_s - first_s)) ++split;
  return Complement(problem.rows(), {{split, problem.rows()}});
}

}  // namespace gyrobench::calibration
