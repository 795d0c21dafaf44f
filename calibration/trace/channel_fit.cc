#include "calibration/trace/channel_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "calibration/trace/noise_search.h"

namespace gyrobench::calibration {
namespace {

constexpr double kWindow_s = 10.0;
constexpr int kBlocks = 10;
constexpr int kBootstrap = 400;
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
    out.col(static_cast<Eigen::Index>(k)) =
        (selection.White(above) - selection.White(below)) * coefficients / (2.0 * step);
  }
  return out;
}

// Parameters that are searched for, not places that a scan or a grid gave.
bool Continuous(const Candidate& member) {
  return member.effect != nullptr && !member.effect->nonlinear.empty() &&
         (member.refinable() || member.id == "bias.tone" || member.id == "angle.ripple");
}

// Least squares from products; dependent columns get 0, those that training cannot see too.
Eigen::VectorXd SolveProducts(const Eigen::MatrixXd& gram, const Eigen::VectorXd& right,
                              const Eigen::VectorXd& whole, std::vector<Eigen::Index>* unseen) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index j = 0; j < gram.rows(); ++j) {
    if (gram(j, j) > 1e-9 * whole(j)) {
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

  // Coefficients from all rows but [begin, end); what these rows alone know is fitted on them.
  Eigen::VectorXd TrainWithout(Eigen::Index begin, Eigen::Index end) const {
    const auto test = white_.middleRows(begin, end - begin);
    const Eigen::MatrixXd gram = test.transpose() * test;
    const Eigen::VectorXd right = test.transpose() * output_.segment(begin, end - begin);
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
  double TestSquare(const Eigen::VectorXd& theta, Eigen::Index begin, Eigen::Index end) const {
    return (output_.segment(begin, end - begin) - white_.middleRows(begin, end - begin) * theta)
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

std::vector<Eigen::Index> Blocks(const ChannelProblem& problem) {
  std::vector<Eigen::Index> edges;
  if (problem.run_begins().size() >= 3) {
    edges = problem.run_begins();
  } else {
    for (int b = 0; b < kBlocks; ++b) edges.push_back(problem.rows() * b / kBlocks);
  }
  edges.push_back(problem.rows());
  return edges;
}

std::vector<Eigen::Index> AllBut(Eigen::Index count, const std::vector<Eigen::Index>& without) {
  std::vector<Eigen::Index> out;
  for (Eigen::Index j = 0; j < count; ++j) {
    if (std::find(without.begin(), without.end(), j) == without.end()) out.push_back(j);
  }
  return out;
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

double ChannelFit::whitened_rms() const {
  return std::sqrt(WhiteResidual().squaredNorm() / static_cast<double>(white_output.size()));
}

ChannelFit FitChannel(const ChannelProblem& problem, const Selection& selection) {
  ChannelFit fit;
  const WhiteStore::Columns columns = selection.ModelColumns();
  const WhiteStore::Solution solution = selection.store().Solve(columns);
  fit.linear = solution.coefficients;
  fit.white = selection.store().Take(columns);
  fit.white_output = selection.store().output();
  fit.baseline_columns = static_cast<Eigen::Index>(selection.baseline_columns().size());
  fit.raw.resize(problem.rows(), fit.white.cols());
  fit.raw.leftCols(fit.baseline_columns) = problem.MakeBaseline().columns;
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
    if (Continuous(member)) slopes = Slopes(selection, member, c);
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
  const std::vector<Eigen::Index> edges = Blocks(problem);
  std::vector<double> white_before, white_after;
  Windows windows_before, windows_after;
  auto append = [](Windows* to, const Windows& from) {
    to->square.insert(to->square.end(), from.square.begin(), from.square.end());
    to->count.insert(to->count.end(), from.count.begin(), from.count.end());
  };
  for (std::size_t b = 0; b + 1 < edges.size(); ++b) {
    const Eigen::VectorXd theta_before = before.TrainWithout(edges[b], edges[b + 1]);
    const Eigen::VectorXd theta_after = after.TrainWithout(edges[b], edges[b + 1]);
    white_before.push_back(before.TestSquare(theta_before, edges[b], edges[b + 1]));
    white_after.push_back(after.TestSquare(theta_after, edges[b], edges[b + 1]));
    append(&windows_before,
           AngleWindows(problem, before.RawResidual(problem.output_deg(), theta_before), edges[b],
                        edges[b + 1]));
    append(&windows_after,
           AngleWindows(problem, after.RawResidual(problem.output_deg(), theta_after), edges[b],
                        edges[b + 1]));
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

HeldOut Forecast(const ChannelProblem& problem, const ChannelFit& fit, std::uint64_t seed) {
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
    const Eigen::VectorXd theta = splitter.TrainWithout(split, problem.rows());
    return AngleWindows(problem, splitter.RawResidual(problem.output_deg(), theta), split,
                        problem.rows());
  };
  const Windows a = windows(before), b = windows(after);
  out.before = a.rms();
  out.after = b.rms();
  out.reduction_ci95 = ReductionInterval(a.square, b.square, seed);
  return out;
}

}  // namespace gyrobench::calibration
