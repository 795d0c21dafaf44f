// How the rows of a problem are divided into those that a model is made from and those that it is
// tried on.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace gyrobench::calibration {

struct Baseline;
class ChannelProblem;

struct RowRange {
  Eigen::Index begin = 0, end = 0;
  Eigen::Index size() const { return end - begin; }
};
using RowRanges = std::vector<RowRange>;

// A variance that grows by more than this without some rows: they alone knew.
inline constexpr double kLostSight = 4.0;

struct Split {
  std::vector<Eigen::Index> training;  // in order
  RowRanges rest;                      // all other rows
};

// Products of columns over some of their rows.
Eigen::MatrixXd ProductsOf(const Eigen::MatrixXd& columns, const RowRange& range);

// Blocks in time: 20 s or a hundredth of the whole, whichever is longer. None goes over the end of
// a power-on, whose last one may be half as long, and a short power-on is one block.
RowRanges Blocks(const ChannelProblem& problem);
// One block in three is the rest. The first of each power-on is training, and so is what alone
// shows a column of the baseline. nullopt where nothing would be left to be tried on.
std::optional<Split> EveryThirdBlock(const ChannelProblem& problem, const Baseline& baseline);
// The first 60 % of the time are training. nullopt with more than one measurement, too few rows, or
// where they show nothing of a column of the baseline.
std::optional<Split> FirstPart(const ChannelProblem& problem, const Baseline& baseline);

}  // namespace gyrobench::calibration
