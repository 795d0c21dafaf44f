#include <algorithm>

#include "calibration/gls/foretold.h"
#include "calibration/gls/independent_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/held_out.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/split.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kFolds = 10, kRunsToHoldOut = 3;
// Weight of the rows that are held out: next to none, which fits what is theirs alone, as a
// constant of their own; and a tenth where they know more of something than the others do, as of a
// resonance that is passed once: by the others alone they would be met by an extrapolation.
constexpr double kWeight = 1e-3, kWeightOfThoseWhoKnow = 0.1;

// Rows that are held out, and the products of a model's white columns over them.
struct Fold {
  RowRanges rows;
  Eigen::MatrixXd products;
};

// A model on part of the rows, applied to another part. Non-linear parameters move along their
// slopes: they are trained like the others.
class Splitter {
 public:
  // `without`: linear columns that the model goes without.
  Splitter(const ChannelFit& fit, const std::vector<Eigen::Index>& without)
      : output_(fit.white_output) {
    const std::vector<Eigen::Index> columns = fit.ColumnsBut(without);
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
    const std::vector<Eigen::Index> in_more = fit.PlacesInMore(columns, slopes);
    gram_ = white_.transpose() * white_ + fit.more_products(in_more, in_more);
    right_ = white_.transpose() * output_ + fit.more_with_output(in_more);
    independent_ = IndependentColumns(gram_);
  }

  Fold FoldOf(const RowRanges& rows) const {
    Fold fold = {rows, Eigen::MatrixXd::Zero(gram_.rows(), gram_.cols())};
    for (const RowRange& range : rows) fold.products += ProductsOf(white_, range);
    return fold;
  }
  std::vector<Fold> FoldsOf(const std::vector<RowRanges>& some) const {
    std::vector<Fold> folds;
    for (const RowRanges& rows : some) folds.push_back(FoldOf(rows));
    return folds;
  }

  // Coefficients from all rows, those of the fold with a weight of their own. What acts in the
  // fold alone, as a step of an angle at one moment, is what they say of it: where the bias walks
  // the white rows after it have a little of it each, and would say more than those with the
  // weight.
  Eigen::VectorXd TrainWithout(const Fold& fold, double weight) const {
    Eigen::VectorXd right = right_;
    for (const RowRange& range : fold.rows) {
      const auto test = white_.middleRows(range.begin, range.size());
      right.noalias() -=
          (1.0 - weight) * test.transpose() * output_.segment(range.begin, range.size());
    }
    Eigen::VectorXd theta = SolveIndependent(gram_ - (1.0 - weight) * fold.products, right);
    const std::vector<Eigen::Index> own = LocalTo(fold.rows);
    theta(own).setZero();
    const Eigen::VectorXd left = right_(own) - gram_(own, Eigen::all) * theta;
    theta(own) = SolveIndependent(gram_(own, own), left);
    return theta;
  }
  // Without these rows every column that is not their own is known nearly as well.
  bool SeesWithout(const Fold& fold) const {
    const Eigen::MatrixXd gram = gram_ - fold.products;
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
  // As `theta` foretells the rows, that was trained with them at `weight`: the rest of their weight
  // is what was held out.
  double LogDensity(const Eigen::VectorXd& theta, const Fold& fold, double weight) const {
    const double share = 1.0 - weight;
    Eigen::VectorXd scores = Eigen::VectorXd::Zero(gram_.rows());
    double square = 0.0;
    for (const RowRange& range : fold.rows) {
      const auto test = white_.middleRows(range.begin, range.size());
      const Eigen::VectorXd residual = output_.segment(range.begin, range.size()) - test * theta;
      scores.noalias() += test.transpose() * residual;
      square += residual.squaredNorm();
    }
    const HeldOutRows held_out = {share * fold.products(independent_, independent_),
                                  share * scores(independent_), share * square};
    const Eigen::MatrixXd training = gram_(independent_, independent_) - held_out.products;
    std::vector<Eigen::Index> own;
    const std::vector<Eigen::Index> local = LocalTo(fold.rows);
    for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(independent_.size()); ++k) {
      if (std::ranges::find(local, independent_[static_cast<std::size_t>(k)]) != local.end())
        own.push_back(k);
    }
    return LogForetold(training, held_out, own);
  }
  Eigen::VectorXd RawResidual(const Eigen::VectorXd& output, const Eigen::VectorXd& theta) const {
    return output - raw_ * theta;
  }

 private:
  std::vector<Eigen::Index> LocalTo(const RowRanges& ranges) const {
    constexpr double kRounding = 1e-12;
    std::vector<Eigen::Index> out;
    for (Eigen::Index j = 0; j < raw_.cols(); ++j) {
      if (!local_[static_cast<std::size_t>(j)]) continue;
      double inside = 0.0;
      for (const RowRange& range : ranges)
        inside += raw_.col(j).segment(range.begin, range.size()).squaredNorm();
      if (inside > (1.0 - kRounding) * raw_.col(j).squaredNorm()) out.push_back(j);
    }
    return out;
  }

  Eigen::MatrixXd white_, raw_;
  std::vector<bool> local_;  // of each column
  const Eigen::VectorXd& output_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd right_;
  std::vector<Eigen::Index> independent_;  // columns
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
  std::vector<Fold> folds = after.FoldsOf(FoldsOfRuns(problem));
  // A measurement that alone shows what a column does cannot be held out by itself.
  if (!std::ranges::all_of(folds, [&](const Fold& fold) { return after.SeesWithout(fold); }))
    folds.clear();
  const bool whole_runs = !folds.empty();
  if (!whole_runs) folds = after.FoldsOf(FoldsOfBlocks(problem));
  if (folds.size() < 2) return {};
  TriedRows tried_before, tried_after;
  auto test = [&](const Splitter& splitter, const Fold& fold, double weight, TriedRows* tried) {
    const Eigen::VectorXd theta = splitter.TrainWithout(fold, weight);
    tried->log_density += splitter.LogDensity(theta, fold, weight);
    const Eigen::VectorXd residual = splitter.RawResidual(problem.output_deg(), theta);
    for (const RowRange& range : fold.rows) {
      tried->rows += static_cast<double>(range.size());
      tried->squares.push_back(splitter.TestSquare(theta, range));
      tried->windows.Append(AngleWindows(problem, residual, range.begin, range.end));
    }
  };
  for (const Fold& fold : folds) {
    const double weight = whole_runs || after.SeesWithout(fold) ? kWeight : kWeightOfThoseWhoKnow;
    test(before, before.FoldOf(fold.rows), weight, &tried_before);
    test(after, fold, weight, &tried_after);
  }
  return Compare(tried_before, tried_after, seed);
}

}  // namespace gyrobench::calibration
