#include "calibration/trace/hold_out.h"

#include <algorithm>

#include "calibration/trace/angle_windows.h"
#include "calibration/trace/noise_search.h"
#include "calibration/trace/scaled_ldlt.h"
#include "calibration/trace/split.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kFolds = 10, kRunsToHoldOut = 3;
// Of a column's square: less in the training rows is the whitener's memory of what happened in the
// others.
constexpr double kSeen = 1e-2;
// What only one moment knows is trained where more than this is to be seen of it.
constexpr double kMostOf = 0.5;
// A variance that grows by more when a measurement is held out: that one alone knew.
constexpr double kLostSight = 4.0;

// Least squares from products; dependent columns get 0, those that training cannot see too.
Eigen::VectorXd SolveProducts(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                              const Eigen::VectorXd& whole, std::vector<Eigen::Index>* unseen) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index j = 0; j < gram.rows(); ++j) {
    if (gram(j, j) > kSeen * whole(j)) {
      seen.push_back(j);
    } else if (unseen != nullptr) {
      unseen->push_back(j);
    }
  }
  Eigen::VectorXd out = Eigen::VectorXd::Zero(gram.rows());
  out(seen) = SolveIndependent(gram(seen, seen), right(seen));
  return out;
}

std::vector<Eigen::Index> AllBut(Eigen::Index count, const std::vector<Eigen::Index>& without) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index j = 0; j < count; ++j) {
    if (std::find(without.begin(), without.end(), j) == without.end()) out.push_back(j);
  }
  return out;
}

// A model on part of the rows, applied to another part. Non-linear parameters move along their
// slopes: they are trained like the others.
class Splitter {
 public:
  // `without`: linear columns that the model goes without.
  Splitter(const ChannelFit& fit, const std::vector<Eigen::Index>& without)
      : baseline_(fit.baseline_columns), output_(fit.white_output) {
    const std::vector<Eigen::Index> columns = AllBut(fit.raw.cols(), without);
    for (const Eigen::Index j : columns) local_.push_back(fit.local[static_cast<std::size_t>(j)]);
    std::vector<Eigen::Index> slopes;
    for (std::size_t i = 0; i < fit.column_begin.size(); ++i) {
      const bool there =
          std::find(without.begin(), without.end(), fit.column_begin[i]) == without.end();
      if (!there) continue;
      for (const Eigen::Index j : fit.SlopesOf(i)) slopes.push_back(j);
    }
    local_.resize(columns.size() + slopes.size(), false);
    const auto rows = fit.raw.rows(), count = static_cast<Eigen::Index>(local_.size());
    white_.resize(rows, count);
    white_ << fit.white(Eigen::all, columns), fit.white_slopes(Eigen::all, slopes);
    raw_.resize(rows, count);
    raw_ << fit.raw(Eigen::all, columns), fit.raw_slopes(Eigen::all, slopes);
    gram_ = white_.transpose() * white_;
    right_ = white_.transpose() * output_;
  }

  // Coefficients from all rows but those of the ranges. What only these know, as a measurement's
  // own constant, is fitted on them where that is asked for, and is 0 otherwise.
  Eigen::VectorXd TrainWithout(const RowRanges& ranges, bool fit_local) const {
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(gram_.rows(), gram_.cols());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(gram_.rows());
    for (const RowRange& range : ranges) {
      const auto test = white_.middleRows(range.begin, range.size());
      gram.noalias() += test.transpose() * test;
      right.noalias() += test.transpose() * output_.segment(range.begin, range.size());
    }
    std::vector<Eigen::Index> unseen;
    // The filter carries some of a moment into other rows: too little to train by.
    Eigen::VectorXd whole = gram_.diagonal();
    for (Eigen::Index j = 0; fit_local && j < whole.size(); ++j) {
      if (local_[static_cast<std::size_t>(j)] && j >= baseline_) whole(j) *= kMostOf / kSeen;
    }
    Eigen::VectorXd theta = SolveProducts(gram_ - gram, right_ - right, whole, &unseen);
    std::erase_if(unseen, [&](Eigen::Index j) { return !local_[static_cast<std::size_t>(j)]; });
    if (unseen.empty() || !fit_local) return theta;
    const Eigen::VectorXd left = right - gram * theta;
    const Eigen::MatrixXd sub = gram(unseen, unseen);
    const Eigen::VectorXd part = left(unseen);
    const Eigen::VectorXd own = SolveProducts(sub, part, sub.diagonal(), nullptr);
    for (std::size_t i = 0; i < unseen.size(); ++i)
      theta(unseen[i]) = own(static_cast<Eigen::Index>(i));
    return theta;
  }
  // Without these rows every column that is not their own is known nearly as well.
  bool SeesWithout(const RowRanges& ranges) const {
    Eigen::MatrixXd gram = gram_;
    for (const RowRange& range : ranges) {
      const auto test = white_.middleRows(range.begin, range.size());
      gram.noalias() -= test.transpose() * test;
    }
    std::vector<Eigen::Index> common;
    for (Eigen::Index j = 0; j < gram.rows(); ++j) {
      if (!local_[static_cast<std::size_t>(j)]) common.push_back(j);
    }
    const auto count = static_cast<Eigen::Index>(common.size());
    const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(count, count);
    const Eigen::VectorXd all = ScaledLdlt(gram_(common, common)).Solve(identity).diagonal();
    const Eigen::VectorXd some = ScaledLdlt(gram(common, common)).Solve(identity).diagonal();
    return (some.array() > 0.0).all() && (some.array() < kLostSight * all.array()).all();
  }
  double TestSquare(const Eigen::VectorXd& theta, const RowRange& range) const {
    return (output_.segment(range.begin, range.size()) -
            white_.middleRows(range.begin, range.size()) * theta)
        .squaredNorm();
  }
  Eigen::VectorXd RawResidual(const Eigen::VectorXd& output, const Eigen::VectorXd& theta) const {
    return output - raw_ * theta;
  }

 private:
  Eigen::Index baseline_;  // columns that belong to it
  Eigen::MatrixXd white_, raw_;
  std::vector<bool> local_;  // of each column
  const Eigen::VectorXd& output_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd right_;
};

// Whole measurements.
std::vector<RowRanges> FoldsOfRuns(const ChannelProblem& problem) {
  std::vector<RowRanges> folds;
  const std::vector<Eigen::Index>& runs = problem.run_begins();
  if (runs.size() < kRunsToHoldOut) return folds;
  for (std::size_t r = 0; r < runs.size(); ++r)
    folds.push_back({{runs[r], r + 1 < runs.size() ? runs[r + 1] : problem.rows()}});
  return folds;
}

// Every tenth of short blocks in time.
std::vector<RowRanges> FoldsOfBlocks(const ChannelProblem& problem) {
  std::vector<RowRanges> folds(kFolds);
  std::size_t block = 0;
  for (const RowRange& range : Blocks(problem)) {
    // Another order in each round: what repeats with the rounds must not meet one fold alone.
    folds[(3 * block + block / kFolds) % kFolds].push_back(range);
    ++block;
  }
  std::erase_if(folds, [](const RowRanges& fold) { return fold.empty(); });
  return folds;
}

}  // namespace

HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed) {
  const Splitter before(fit, without), after(fit, {});
  std::vector<RowRanges> folds = FoldsOfRuns(problem);
  // A measurement that alone shows what a column does cannot be held out by itself.
  if (!std::ranges::all_of(folds, [&](const RowRanges& fold) { return after.SeesWithout(fold); }))
    folds.clear();
  if (folds.empty()) folds = FoldsOfBlocks(problem);
  if (folds.size() < 2) return {};
  TriedRows tried_before, tried_after;
  auto test = [&](const Splitter& splitter, const RowRanges& fold, TriedRows* tried) {
    const Eigen::VectorXd theta = splitter.TrainWithout(fold, true);
    const Eigen::VectorXd residual = splitter.RawResidual(problem.output_deg(), theta);
    for (const RowRange& range : fold) {
      tried->rows += static_cast<double>(range.size());
      tried->squares.push_back(splitter.TestSquare(theta, range));
      tried->windows.Append(AngleWindows(problem, residual, range.begin, range.end));
    }
  };
  for (const RowRanges& fold : folds) {
    test(before, fold, &tried_before);
    test(after, fold, &tried_after);
  }
  return Compare(tried_before, tried_after, seed);
}

}  // namespace gyrobench::calibration
