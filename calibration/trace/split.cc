#include "calibration/trace/split.h"

#include <algorithm>
#include <limits>

#include "calibration/gls/independent_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastBlock_s = 20.0, kMostBlocks = 100.0;
constexpr double kFirstShare = 0.6;
// Of a block: what is left of a power-on and shorter joins the block before.
constexpr double kLeastTail = 0.5;
constexpr Eigen::Index kLeastForecastRows = 100;
// A forecast knows less of what goes on growing, as a power of the temperature; beyond this it
// knows nothing.
constexpr double kBlind = 1000.0;
// Place of the rest among three blocks, in turn: what repeats with the blocks must not meet one
// place alone, and no two blocks of the rest lie side by side.
constexpr std::size_t kPlaces[] = {1, 0, 2};

Eigen::VectorXd Variances(const Eigen::MatrixXd& gram) {
  return ScaledLdlt(gram).Solve(Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).diagonal();
}

// What of the baseline can be known without some rows; columns that depend on others count once.
class Sight {
 public:
  explicit Sight(const Eigen::MatrixXd& columns) {
    const Eigen::MatrixXd all = columns.transpose() * columns;
    columns_ = columns(Eigen::all, IndependentColumns(all));
    training_ = columns_.transpose() * columns_;
    whole_ = Variances(training_);
  }

  void Without(const RowRange& range) { training_ -= ProductsOf(columns_, range); }
  void With(const RowRange& range) { training_ += ProductsOf(columns_, range); }

  // The column that training has lost most of; nullopt where no variance has grown by more.
  std::optional<Eigen::Index> Lost(double limit) const {
    const Eigen::VectorXd variances = Variances(training_);
    std::optional<Eigen::Index> worst;
    double most = limit;
    for (Eigen::Index j = 0; j < whole_.size(); ++j) {
      // None, or a negative one, is a column of which nothing is left.
      const double grown =
          variances(j) > 0.0 ? variances(j) / whole_(j) : std::numeric_limits<double>::infinity();
      if (!(grown > most)) continue;
      worst = j;
      most = grown;
    }
    return worst;
  }

  double Square(Eigen::Index column, const RowRange& range) const {
    return columns_.col(column).segment(range.begin, range.size()).squaredNorm();
  }

 private:
  Eigen::MatrixXd columns_;  // independent ones
  Eigen::MatrixXd training_;
  Eigen::VectorXd whole_;  // variances with all rows
};

// Gives back to training what it cannot do without.
void KeepSight(const Eigen::MatrixXd& columns, RowRanges* rest) {
  Sight sight(columns);
  for (const RowRange& range : *rest) sight.Without(range);
  while (!rest->empty()) {
    const std::optional<Eigen::Index> lost = sight.Lost(kLostSight);
    if (!lost) return;
    const auto most_of_it = std::ranges::max_element(
        *rest, {}, [&](const RowRange& r) { return sight.Square(*lost, r); });
    sight.With(*most_of_it);
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

Eigen::MatrixXd ProductsOf(const Eigen::MatrixXd& columns, const RowRange& range) {
  const auto some = columns.middleRows(range.begin, range.size());
  return some.transpose() * some;
}

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
    const bool joins = filled_s < kLeastTail * block_s && begin > 0 &&
                       problem.power_on(begin) == problem.power_on(begin - 1);
    if (joins) {
      blocks.back().end = i + 1;
    } else {
      blocks.push_back({begin, i + 1});
    }
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
  KeepSight(baseline.columns.leftCols(baseline.of_sensor()), &rest);
  if (rest.empty()) return std::nullopt;
  return Complement(problem.rows(), std::move(rest));
}

std::optional<Split> FirstPart(const ChannelProblem& problem, const Baseline& baseline) {
  if (problem.run_begins().size() != 1 || problem.rows() < kLeastForecastRows) return std::nullopt;
  const double first_s = problem.begin_s(0), last_s = problem.end_s(problem.rows() - 1);
  Eigen::Index split = 0;
  while (problem.end_s(split) < first_s + kFirstShare * (last_s - first_s)) ++split;
  const RowRange rest = {split, problem.rows()};
  Sight sight(baseline.columns.leftCols(baseline.of_sensor()));
  sight.Without(rest);
  if (sight.Lost(kBlind)) return std::nullopt;
  return Complement(problem.rows(), {rest});
}

}  // namespace gyrobench::calibration
