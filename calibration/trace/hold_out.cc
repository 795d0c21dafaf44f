#include "calibration/trace/hold_out.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/trace/angle_windows.h"
#include "calibration/trace/noise_search.h"
#include "calibration/trace/scaled_ldlt.h"

namespace gyrobench::calibration {
namespace {

constexpr std::size_t kFolds = 10, kRunsToHoldOut = 3;
constexpr double kLeastBlock_s = 20.0, kMostBlocks = 100.0;
constexpr int kBootstrap = 400;
// Of a column's square: less in the training rows is the whitener's memory of what happened in the
// others.
constexpr double kSeen = 1e-2;
// What only one moment knows is trained where more than this is to be seen of it.
constexpr double kMostOf = 0.5;
constexpr double kTrainingShare = 0.6;
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
  std::vector<Eigen::Index> kept;
  for (const Eigen::Index k : IndependentColumns(gram(seen, seen)))
    kept.push_back(seen[static_cast<std::size_t>(k)]);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(gram.rows());
  out(kept) = ScaledLdlt(gram(kept, kept)).Solve(Eigen::VectorXd(right(kept)));
  return out;
}

struct Range {
  Eigen::Index begin = 0, end = 0;
  Eigen::Index size() const { return end - begin; }
};
using Ranges = std::vector<Range>;

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
      const Eigen::Index end =
          i + 1 < fit.slope_begin.size() ? fit.slope_begin[i + 1] : fit.raw_slopes.cols();
      for (Eigen::Index j = fit.slope_begin[i]; there && j < end; ++j) slopes.push_back(j);
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
  Eigen::VectorXd TrainWithout(const Ranges& ranges, bool fit_local) const {
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(gram_.rows(), gram_.cols());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(gram_.rows());
    for (const Range& range : ranges) {
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
  bool SeesWithout(const Ranges& ranges) const {
    Eigen::MatrixXd gram = gram_;
    for (const Range& range : ranges) {
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
  double TestSquare(const Eigen::VectorXd& theta, const Range& range) const {
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
std::vector<Ranges> FoldsOfRuns(const ChannelProblem& problem) {
  std::vector<Ranges> folds;
  const std::vector<Eigen::Index>& runs = problem.run_begins();
  if (runs.size() < kRunsToHoldOut) return folds;
  for (std::size_t r = 0; r < runs.size(); ++r)
    folds.push_back({{runs[r], r + 1 < runs.size() ? runs[r + 1] : problem.rows()}});
  return folds;
}

// Every tenth of short blocks in time.
std::vector<Ranges> FoldsOfBlocks(const ChannelProblem& problem) {
  std::vector<Ranges> folds(kFolds);
  double time_s = 0.0;
  for (const Interval& interval : problem.intervals()) time_s += interval.duration_s;
  const double block_s = std::max(kLeastBlock_s, time_s / kMostBlocks);
  double filled_s = 0.0;
  std::size_t block = 0;
  Eigen::Index begin = 0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    filled_s += problem.intervals()[static_cast<std::size_t>(i)].duration_s;
    if (filled_s < block_s && i + 1 < problem.rows()) continue;
    // Another order in each round: what repeats with the rounds must not meet one fold alone.
    folds[(3 * block + block / kFolds) % kFolds].push_back({begin, i + 1});
    begin = i + 1;
    filled_s = 0.0;
    ++block;
  }
  std::erase_if(folds, [](const Ranges& fold) { return fold.empty(); });
  return folds;
}

// Where the bias has walked to at the end of the rows: of white noise and a random walk the steady
// filter is a mean that forgets within N / K.
double LastBias(const ChannelProblem& problem,
                const Eigen::Ref<const Eigen::VectorXd>& residual_deg, const IntervalNoise& noise) {
  constexpr double kLeastMemory_s = 60.0;  // what comes and goes faster is no drift
  const double memory_s = std::max(
      kLeastMemory_s, noise.angle_random_walk_deg_sqrt_s / noise.bias_random_walk_deg_s_sqrt_s);
  const double end_s = problem.end_s(residual_deg.size() - 1);
  double sum = 0.0, time_s = 0.0;
  for (Eigen::Index i = 0; i < residual_deg.size(); ++i) {
    const double weight = std::exp((problem.end_s(i) - end_s) / memory_s);
    sum += weight * residual_deg(i);
    time_s += weight * problem.intervals()[static_cast<std::size_t>(i)].duration_s;
  }
  return time_s > 0 ? sum / time_s : 0.0;
}

double Ratio(const std::vector<double>& before, const std::vector<double>& after,
             const std::vector<std::size_t>& chosen) {
  double a = 0.0, b = 0.0;
  for (const std::size_t i : chosen) {
    b += before[i];
    a += after[i];
  }
  return std::sqrt(a / b);
}

// 95 % interval of 1 - rms after / rms before: the groups drawn anew, with replacement.
std::array<double, 2> ReductionInterval(const std::vector<double>& before,
                                        const std::vector<double>& after, std::uint64_t seed) {
  if (before.size() < 4) return {kMissing, kMissing};
  std::mt19937_64 random(seed);
  std::vector<double> reductions;
  std::vector<std::size_t> chosen(before.size());
  for (int i = 0; i < kBootstrap; ++i) {
    for (std::size_t& index : chosen) index = random() % before.size();
    reductions.push_back(1.0 - Ratio(before, after, chosen));
  }
  std::sort(reductions.begin(), reductions.end());
  return {reductions[static_cast<std::size_t>(0.025 * kBootstrap)],
          reductions[static_cast<std::size_t>(0.975 * kBootstrap) - 1]};
}

}  // namespace

HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed) {
  const Splitter before(fit, without), after(fit, {});
  std::vector<Ranges> folds = FoldsOfRuns(problem);
  // A measurement that alone shows what a column does cannot be held out by itself.
  if (!std::ranges::all_of(folds, [&](const Ranges& fold) { return after.SeesWithout(fold); }))
    folds.clear();
  if (folds.empty()) folds = FoldsOfBlocks(problem);
  if (folds.size() < 2) return {};
  std::vector<double> white_before, white_after;
  Windows windows_before, windows_after;
  auto test = [&](const Splitter& splitter, const Ranges& fold, std::vector<double>* squares,
                  Windows* windows) {
    const Eigen::VectorXd theta = splitter.TrainWithout(fold, true);
    const Eigen::VectorXd residual = splitter.RawResidual(problem.output_deg(), theta);
    for (const Range& range : fold) {
      squares->push_back(splitter.TestSquare(theta, range));
      windows->Append(AngleWindows(problem, residual, range.begin, range.end));
    }
  };
  for (const Ranges& fold : folds) {
    test(before, fold, &white_before, &windows_before);
    test(after, fold, &white_after, &windows_after);
  }
  auto total = [&](const std::vector<double>& squares) {
    double sum = 0.0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum / static_cast<double>(problem.rows()));
  };
  HeldOutFigures out;
  out.whitened_rms = {total(white_before), total(white_after),
                      ReductionInterval(white_before, white_after, seed)};
  out.angle_rms_deg = {windows_before.rms(), windows_after.rms(),
                       ReductionInterval(windows_before.square, windows_after.square, seed)};
  return out;
}

HeldOut Forecast(const ChannelProblem& problem, const ChannelFit& fit, const IntervalNoise& noise,
                 std::uint64_t seed) {
  HeldOut out;
  if (problem.run_begins().size() != 1 || problem.rows() < 100) return out;
  const double first = problem.begin_s(0), last = problem.end_s(problem.rows() - 1);
  Eigen::Index split = 0;
  while (problem.end_s(split) < first + kTrainingShare * (last - first)) ++split;
  std::vector<Eigen::Index> effects;
  for (Eigen::Index j = fit.baseline_columns; j < fit.raw.cols(); ++j) effects.push_back(j);
  const Splitter before(fit, effects), after(fit, {});
  auto windows = [&](const Splitter& splitter) {
    const Eigen::VectorXd theta = splitter.TrainWithout({{split, problem.rows()}}, false);
    Eigen::VectorXd residual = splitter.RawResidual(problem.output_deg(), theta);
    const double bias_deg_s = LastBias(problem, residual.head(split), noise);
    for (Eigen::Index i = split; i < residual.size(); ++i)
      residual(i) -= bias_deg_s * problem.intervals()[static_cast<std::size_t>(i)].duration_s;
    return AngleWindows(problem, residual, split, problem.rows());
  };
  const Windows a = windows(before), b = windows(after);
  out.before = a.rms();
  out.after = b.rms();
  out.reduction_ci95 = ReductionInterval(a.square, b.square, seed);
  return out;
}

}  // namespace gyrobench::calibration
