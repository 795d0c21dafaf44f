#include "calibration/trace/channel_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/trace/noise_search.h"

namespace gyrobench::calibration {
namespace {

constexpr double kWindow_s = 10.0;
constexpr std::size_t kFolds = 10, kRunsToHoldOut = 3;
constexpr double kLeastBlock_s = 20.0, kMostBlocks = 100.0;
constexpr int kBootstrap = 400;
constexpr double kLeastScale = 1e-3;
// Of a column's square: less in the training rows is the whitener's memory of what happened in the
// others.
constexpr double kSeen = 1e-2;
constexpr double kTrainingShare = 0.6;

// d(columns c) / d theta of each non-linear parameter, white.
Eigen::MatrixXd Slopes(const Selection& selection, const Candidate& member,
                       const Eigen::VectorXd& coefficients) {
  const std::size_t count = member.effect == nullptr ? 0 : member.context.nonlinear.size();
  Eigen::MatrixXd out(selection.store().rows(), static_cast<Eigen::Index>(count));
  for (std::size_t k = 0; k < count; ++k) {
    Candidate above = member, below = member;
    const double step = 1e-4 * std::max(std::fabs(member.context.nonlinear[k]), 1e-3);
    above.context.nonlinear[k] += step;
    below.context.nonlinear[k] -= step;
    above.raw = below.raw = nullptr;
    out.col(static_cast<Eigen::Index>(k)) =
        (selection.White(above) - selection.White(below)) * coefficients / (2.0 * step);
  }
  return out;
}

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
  const Eigen::MatrixXd sub = gram(seen, seen);
  const Eigen::VectorXd scale = sub.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * sub * scale.asDiagonal();
  const std::vector<Eigen::Index> kept = IndependentColumns(scaled);
  const Eigen::MatrixXd core = scaled(kept, kept);
  const Eigen::VectorXd part = (scale.asDiagonal() * Eigen::VectorXd(right(seen)))(kept);
  const Eigen::VectorXd theta = core.ldlt().solve(part);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(gram.rows());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Eigen::Index j = kept[i];
    out(seen[static_cast<std::size_t>(j)]) = theta(static_cast<Eigen::Index>(i)) * scale(j);
  }
  return out;
}

struct Range {
  Eigen::Index begin = 0, end = 0;
  Eigen::Index size() const { return end - begin; }
};
using Ranges = std::vector<Range>;

// A linear model on part of the rows, applied to another part.
class Splitter {
 public:
  Splitter(const ChannelFit& fit, std::vector<Eigen::Index> columns)
      : columns_(std::move(columns)),
        white_(fit.white(Eigen::all, columns_)),
        raw_(fit.raw(Eigen::all, columns_)),
        output_(fit.white_output),
        gram_(white_.transpose() * white_),
        right_(white_.transpose() * output_) {}

  // Coefficients from all rows but those of the ranges; what these alone know is fitted on them.
  Eigen::VectorXd TrainWithout(const Ranges& ranges) const {
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(gram_.rows(), gram_.cols());
    Eigen::VectorXd right = Eigen::VectorXd::Zero(gram_.rows());
    for (const Range& range : ranges) {
      const auto test = white_.middleRows(range.begin, range.size());
      gram.noalias() += test.transpose() * test;
      right.noalias() += test.transpose() * output_.segment(range.begin, range.size());
    }
    std::vector<Eigen::Index> unseen;
    Eigen::VectorXd theta = SolveProducts(gram_ - gram, right_ - right, gram_.diagonal(), &unseen);
    if (unseen.empty()) return theta;
    const Eigen::VectorXd left = right - gram * theta;
    const Eigen::MatrixXd sub = gram(unseen, unseen);
    const Eigen::VectorXd part = left(unseen);
    const Eigen::VectorXd own = SolveProducts(sub, part, sub.diagonal(), nullptr);
    for (std::size_t i = 0; i < unseen.size(); ++i)
      theta(unseen[i]) = own(static_cast<Eigen::Index>(i));
    return theta;
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
  std::vector<Eigen::Index> columns_;
  Eigen::MatrixXd white_, raw_;
  const Eigen::VectorXd& output_;
  Eigen::MatrixXd gram_;
  Eigen::VectorXd right_;
};

// Rows that are held out together: a whole measurement, or every tenth of short blocks in time.
std::vector<Ranges> Folds(const ChannelProblem& problem) {
  std::vector<Ranges> folds;
  const std::vector<Eigen::Index>& runs = problem.run_begins();
  if (runs.size() >= kRunsToHoldOut) {
    for (std::size_t r = 0; r < runs.size(); ++r)
      folds.push_back({{runs[r], r + 1 < runs.size() ? runs[r + 1] : problem.rows()}});
    return folds;
  }
  folds.resize(kFolds);
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

std::vector<Eigen::Index> AllBut(Eigen::Index count, const std::vector<Eigen::Index>& without) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index j = 0; j < count; ++j) {
    if (std::find(without.begin(), without.end(), j) == without.end()) out.push_back(j);
  }
  return out;
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

// An angle or a delay is seen through the gyro's scale factor; what is stated is the angle and the
// delay.
void StateInReferenceScale(const ChannelProblem& problem, const Baseline& baseline,
                           const Selection& selection, ChannelFit* fit) {
  const auto own = std::find(baseline.turned.begin(), baseline.turned.end(), problem.channel());
  if (own == baseline.turned.end()) return;
  const double m = fit->linear(own - baseline.turned.begin());
  if (std::fabs(m) < kLeastScale) return;
  for (std::size_t i = 0; i < selection.members().size(); ++i) {
    const Candidate& member = selection.members()[i];
    if (member.effect == nullptr || member.effect->domain != EffectDomain::kAngle) continue;
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    fit->values.segment(fit->member_begin[i], count) /= m;
    fit->covariance.middleRows(fit->member_begin[i], count) /= m;
    fit->covariance.middleCols(fit->member_begin[i], count) /= m;
  }
}

}  // namespace

double ChannelFit::whitened_rms() const {
  return std::sqrt(WhiteResidual().squaredNorm() / static_cast<double>(white_output.size()));
}

std::vector<Eigen::Index> ChannelFit::ColumnsOf(std::size_t member) const {
  const Eigen::Index end = member + 1 < column_begin.size() ? column_begin[member + 1] : raw.cols();
  std::vector<Eigen::Index> columns;
  for (Eigen::Index j = column_begin[member]; j < end; ++j) columns.push_back(j);
  return columns;
}

ChannelFit FitChannel(const ChannelProblem& problem, const Baseline& baseline,
                      const Selection& selection) {
  ChannelFit fit;
  const WhiteStore::Columns columns = selection.ModelColumns();
  const WhiteStore::Solution solution = selection.store().Solve(columns);
  fit.linear = solution.coefficients;
  fit.white = selection.store().Take(columns);
  fit.white_output = selection.store().output();
  fit.baseline_columns = static_cast<Eigen::Index>(selection.baseline_columns().size());
  fit.raw.resize(problem.rows(), fit.white.cols());
  fit.raw.leftCols(fit.baseline_columns) = baseline.columns;
  Eigen::MatrixXd tangent = fit.white.leftCols(fit.baseline_columns);
  std::vector<double> values(fit.linear.data(), fit.linear.data() + fit.baseline_columns);
  Eigen::Index column = fit.baseline_columns;
  for (const Candidate& member : selection.members()) {
    const auto count = static_cast<Eigen::Index>(member.columns.size());
    fit.column_begin.push_back(column);
    fit.member_begin.push_back(tangent.cols());
    fit.raw.middleCols(column, count) = ColumnsOf(problem, member, selection.covariates());
    const Eigen::VectorXd c = fit.linear.segment(column, count);
    Eigen::MatrixXd slopes(problem.rows(), 0);
    if (member.searched()) slopes = Slopes(selection, member, c);
    const Eigen::Index before = tangent.cols();
    tangent.conservativeResize(Eigen::NoChange, before + count + slopes.cols());
    tangent.middleCols(before, count) = fit.white.middleCols(column, count);
    tangent.rightCols(slopes.cols()) = slopes;
    values.insert(values.end(), c.data(), c.data() + count);
    if (slopes.cols() > 0) {
      values.insert(values.end(), member.context.nonlinear.begin(), member.context.nonlinear.end());
    }
    column += count;
  }
  fit.values = Eigen::Map<Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  const Eigen::MatrixXd gram = tangent.transpose() * tangent;
  const Eigen::VectorXd scale = gram.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * gram * scale.asDiagonal();
  const std::vector<Eigen::Index> kept = IndependentColumns(scaled);
  const Eigen::MatrixXd core = scaled(kept, kept);
  const Eigen::MatrixXd inverse =
      core.ldlt().solve(Eigen::MatrixXd::Identity(core.rows(), core.cols()));
  fit.covariance = Eigen::MatrixXd::Zero(gram.rows(), gram.cols());
  fit.covariance.diagonal().setConstant(kMissing);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    for (std::size_t j = 0; j < kept.size(); ++j) {
      fit.covariance(kept[i], kept[j]) =
          inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * scale(kept[i]) *
          scale(kept[j]);
    }
  }
  StateInReferenceScale(problem, baseline, selection, &fit);
  return fit;
}

double Windows::rms() const {
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0; i < square.size(); ++i) {
    sum += square[i];
    n += count[i];
  }
  return n > 0 ? std::sqrt(sum / n) : kMissing;
}

void Windows::Append(const Windows& others) {
  square.insert(square.end(), others.square.begin(), others.square.end());
  count.insert(count.end(), others.count.begin(), others.count.end());
}

Windows AngleWindows(const ChannelProblem& problem, const Eigen::VectorXd& residual_deg,
                     Eigen::Index begin, Eigen::Index end) {
  Windows out;
  double sum = 0.0, square = 0.0, n = 0.0, angle = 0.0, window_begin = 0.0;
  auto close = [&] {
    if (n >= 10.0) {
      out.square.push_back(std::max(square - sum * sum / n, 0.0));
      out.count.push_back(n);
    }
    sum = square = n = angle = 0.0;
  };
  for (Eigen::Index i = begin; i < end; ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    const bool broken = interval.gap_before_s > 0 || interval.new_reference ||
                        (i > begin && problem.begin_s(i) < problem.begin_s(i - 1));
    if (i == begin || broken || problem.end_s(i) - window_begin > kWindow_s) {
      close();
      window_begin = problem.begin_s(i);
    }
    angle += residual_deg(i);
    sum += angle;
    square += angle * angle;
    n += 1.0;
  }
  close();
  return out;
}

HeldOutFigures HoldOut(const ChannelProblem& problem, const ChannelFit& fit,
                       const std::vector<Eigen::Index>& without, std::uint64_t seed) {
  const Splitter before(fit, AllBut(fit.raw.cols(), without)),
      after(fit, AllBut(fit.raw.cols(), {}));
  std::vector<double> white_before, white_after;
  Windows windows_before, windows_after;
  auto test = [&](const Splitter& splitter, const Ranges& fold, std::vector<double>* squares,
                  Windows* windows) {
    const Eigen::VectorXd theta = splitter.TrainWithout(fold);
    const Eigen::VectorXd residual = splitter.RawResidual(problem.output_deg(), theta);
    for (const Range& range : fold) {
      squares->push_back(splitter.TestSquare(theta, range));
      windows->Append(AngleWindows(problem, residual, range.begin, range.end));
    }
  };
  for (const Ranges& fold : Folds(problem)) {
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
  const Splitter before(fit, AllBut(fit.raw.cols(), effects)),
      after(fit, AllBut(fit.raw.cols(), {}));
  auto windows = [&](const Splitter& splitter) {
    const Eigen::VectorXd theta = splitter.TrainWithout({{split, problem.rows()}});
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
