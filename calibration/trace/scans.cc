#include "calibration/trace/scans.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/geometry.h"
#include "calibration/effects/basis.h"
#include "calibration/gls/filled_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"

namespace gyrobench::calibration {
namespace {

// Steps nearer to an end of a measurement than this are not told from its beginning.
constexpr Eigen::Index kEdgeRows = 20;
constexpr std::size_t kMostTones = 8;     // that look alike
constexpr std::size_t kMostRipples = 24;  // of an axis, to be told from each other by their columns
constexpr double kLeastInformation = 0.02;  // share left after the model
constexpr Eigen::Index kLooked = 16;  // one row in so many tells how alike neighbouring steps are

class Steps {
 public:
  Steps(const ChannelProblem& problem, const Whitener& whitener, const Eigen::MatrixXd& model,
        const Eigen::VectorXd& residual)
      : problem_(problem), whitener_(whitener), residual_(residual), p_(model.cols()) {
    Eigen::MatrixXd all(model.rows(), p_ + 1);
    all << model, residual;
    shocks_ = whitener.Scores(all);
    products_ = Gram(model);
  }

  // `left`: of the information, by the model.
  ScanPeak Best(const Eigen::MatrixXd& score, const Eigen::VectorXd& information,
                const Eigen::VectorXd& left, bool moving_only) const {
    ScanPeak peak;
    ForEachPlace(1, moving_only, [&](Eigen::Index i, Eigen::Index) {
      const double s = score(i, p_);
      if (!(left(i) > kLeastInformation * information(i)) || s * s / left(i) <= peak.gain) return;
      peak.gain = s * s / left(i);
      peak.nonlinear = problem_.begin_s(i) +
                       (moving_only ? 0.5 * (problem_.end_s(i) - problem_.begin_s(i)) : 0.0);
      peak.row = row_ = i;
    });
    return peak;
  }

  ScanPeak Bias() const {
    const Eigen::VectorXd left = Left(shocks_.bias, shocks_.bias_information);
    ScanPeak peak = Best(shocks_.bias, shocks_.bias_information, left, false);
    peak.effect = &ScannedEffect(Search::kTime, EffectDomain::kRate);
    peak.tried = TestsOfBias(left, peak.gain);
    return peak;
  }
  // A step and that of the next row differ by what one row says of the bias.
  double TestsOfBias(const Eigen::VectorXd& left, double gain) const {
    double tests = 1.0;
    ForEachPlace(kLooked, false, [&](Eigen::Index i, Eigen::Index rows) {
      if (!(left(i) > kLeastInformation * shocks_.bias_information(i))) return;
      const double duration_s = problem_.intervals()[static_cast<std::size_t>(i)].duration_s;
      const double one_row = duration_s * duration_s * shocks_.output_information(i);
      tests += static_cast<double>(rows) *
               TestsFromNeighbour(gain, std::min(1.0, 0.5 * one_row / left(i)));
    });
    return tests;
  }
  // `readings`: between which it is placed as well.
  ScanPeak Angle(Eigen::Index readings) const {
    const Eigen::VectorXd left = Left(shocks_.output, shocks_.output_information);
    ScanPeak peak = Best(shocks_.output, shocks_.output_information, left, true);
    peak.effect = &ScannedEffect(Search::kTime, EffectDomain::kAngle);
    peak.tried = static_cast<double>(problem_.rows() + readings);
    peak.tail_freedom = TailFreedom();
    peak.table_axis = AxisThatStepped();
    return peak;
  }
  // Of the rows' scores once the step at the peak is taken off: it is in those around it too.
  double TailFreedom() const {
    Eigen::MatrixXd steps = Eigen::MatrixXd::Zero(problem_.rows(), 2);
    steps(row_, 0) = steps(row_ + 1, 1) = 1.0;
    whitener_.Apply(steps);
    const double square = steps.col(0).squaredNorm();
    const double size = steps.col(0).dot(residual_) / square;
    const Whitener::Shocks left = whitener_.Scores(residual_ - size * steps.col(0));
    // Where readings are noisy beside the gyro a step here and one in the next row are nearly the
    // same, and what is beyond comes in crowds. Squares of normal values correlate by the square of
    // what the values do, and a count of them varies as one of so many fewer would.
    const double alike =
        std::pow(steps.col(0).dot(steps.col(1)), 2) / (square * steps.col(1).squaredNorm());
    const double share = (1.0 - alike) / (1.0 + alike);
    std::vector<double> squares;
    double sum = 0.0;
    for (Eigen::Index i = 0; i < problem_.rows(); ++i) {
      if (!problem_.FeelsTable(i)) continue;
      squares.push_back(std::pow(left.output(i, 0), 2) / left.output_information(i));
      sum += squares.back();
    }
    const auto n = static_cast<double>(squares.size());
    const auto beyond = std::ranges::count_if(squares, [&](double x) { return x > 9.0 * sum / n; });
    return FreedomOfTails(share * static_cast<double>(beyond), share * n);
  }
  // Score of each row's output, of the residual.
  Eigen::VectorXd Output() const { return shocks_.output.col(p_); }

 private:
  // The axis of the table whose reading leaves its way by most about the peak's row, as the channel
  // feels it: the one that stepped, though it may rest there while another turns.
  std::size_t AxisThatStepped() const {
    std::size_t stepped = problem_.table_axes().front();
    double most = 0.0;
    for (std::size_t a = 0; a < 3; ++a) {
      const double by_deg = std::fabs(OffItsWay_deg(a) * problem_.AxisProjection(row_, a));
      if (!(by_deg > most)) continue;
      most = by_deg;
      stepped = a;
    }
    return stepped;
  }
  // Change of an axis's reading over the peak's row and its neighbours, less what the rates before
  // and after them make of it.
  double OffItsWay_deg(std::size_t axis) const {
    const std::size_t row = problem_.row_refs()[static_cast<std::size_t>(row_)].interval;
    const std::vector<SensorState>& nodes = problem_.history(row_).nodes;
    const std::size_t from = row > 0 ? row - 1 : row, to = std::min(row + 2, nodes.size() - 1);
    auto change_deg = [&](std::size_t first, std::size_t last) {
      return nodes[last].table_deg[axis] - nodes[first].table_deg[axis];
    };
    auto length_s = [&](std::size_t first, std::size_t last) {
      return nodes[last].t_s - nodes[first].t_s;
    };
    double rates = 0.0, known = 0.0;
    auto add_rate = [&](std::size_t first, std::size_t last) {
      rates += change_deg(first, last) / length_s(first, last);
      known += 1.0;
    };
    if (from > 0) add_rate(from - 1, from);
    if (to + 1 < nodes.size()) add_rate(to, to + 1);
    const double usual_deg = known > 0.0 ? rates / known * length_s(from, to) : 0.0;
    return change_deg(from, to) - usual_deg;
  }
  // Rows where a step is looked for, each `stride`-th of a run, and for how many it stands.
  template <typename Do>
  void ForEachPlace(Eigen::Index stride, bool moving_only, Do&& at) const {
    const std::vector<Eigen::Index>& begins = problem_.run_begins();
    for (std::size_t run = 0; run < begins.size(); ++run) {
      const Eigen::Index end =
          (run + 1 < begins.size() ? begins[run + 1] : problem_.rows()) - kEdgeRows;
      for (Eigen::Index i = begins[run] + kEdgeRows; i < end; i += stride) {
        if (!moving_only || problem_.FeelsTable(i)) at(i, std::min(stride, end - i));
      }
    }
  }
  // Information on a step at each row that the model leaves.
  Eigen::VectorXd Left(const Eigen::MatrixXd& score, const Eigen::VectorXd& information) const {
    Eigen::VectorXd left = information;
    ForEachStretch(score.leftCols(p_),
                   [&](Eigen::Index begin, Eigen::Index rows,
                       const std::vector<Eigen::Index>& filled, const Eigen::MatrixXd& some) {
                     left.segment(begin, rows) -= FactorOf(filled).Squares(some.transpose());
                   });
    return left;
  }
  const ScaledLdlt& FactorOf(const std::vector<Eigen::Index>& some) const {
    const auto [place, is_new] = factors_.try_emplace(some);
    if (is_new) place->second = WithoutOthers(products_, some);
    return place->second;
  }

  const ChannelProblem& problem_;
  const Whitener& whitener_;
  const Eigen::VectorXd& residual_;
  Eigen::Index p_;
  Whitener::Shocks shocks_;
  Eigen::MatrixXd products_;                                         // of the model's columns
  mutable std::map<std::vector<Eigen::Index>, ScaledLdlt> factors_;  // of FactorOf
  mutable Eigen::Index row_ = 0;
};

void AddAll(const std::vector<ScanPeak>& some, std::vector<ScanPeak>* peaks) {
  peaks->insert(peaks->end(), some.begin(), some.end());
}

void AddRipples(const ChannelProblem& problem, const Eigen::VectorXd& output_score,
                const SingleReadings* readings, std::size_t most_of_an_axis,
                std::vector<ScanPeak>* peaks) {
  for (const std::size_t axis : problem.table_axes()) {
    AddAll(ScanRipple(problem, output_score, readings, axis, most_of_an_axis), peaks);
  }
}

bool TooShort(const ChannelProblem& problem) { return problem.rows() < 4 * kEdgeRows; }

std::vector<ScanPeak> Found(std::vector<ScanPeak> peaks) {
  std::erase_if(peaks, [](const ScanPeak& peak) { return !(peak.gain > 0); });
  std::stable_partition(peaks.begin(), peaks.end(),
                        [](const ScanPeak& peak) { return !peak.last_resort; });
  return peaks;
}

}  // namespace

bool ScanPeak::ComesNear(double log_level) const {
  constexpr double kRoughly = 0.5;
  return gain >= kRoughly * ChiSquareQuantile(log_level, 2.0);
}

double TurnsSpanned(const ChannelProblem& problem, std::size_t axis) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const double angle_deg = problem.half(i, 0).table_deg[axis];
    if (!std::isfinite(angle_deg)) continue;
    low = std::min(low, angle_deg);
    high = std::max(high, angle_deg);
  }
  return high > low ? (high - low) / kFullTurn_deg : 0.0;
}

std::vector<ScanPeak> ScanForNoise(const ChannelProblem& problem, const Whitener& whitener,
                                   const Eigen::MatrixXd& model, const Eigen::VectorXd& residual) {
  if (TooShort(problem)) return {};
  const Steps steps(problem, whitener, model, residual);
  std::vector<ScanPeak> peaks = {steps.Bias()};
  AddAll(ScanTones(problem, residual, 1), &peaks);
  if (!problem.table_axes().empty()) peaks.push_back(steps.Angle(0));
  AddRipples(problem, steps.Output(), nullptr, 1, &peaks);
  return Found(std::move(peaks));
}

std::vector<ScanPeak> Scan(const ChannelProblem& problem, const Whitener& whitener,
                           const Eigen::MatrixXd& model, const Eigen::VectorXd& residual,
                           const SingleReadings& readings) {
  if (TooShort(problem)) return {};
  std::vector<ScanPeak> peaks;
  const Steps steps(problem, whitener, model, residual);
  peaks.push_back(steps.Bias());
  if (!problem.table_axes().empty()) peaks.push_back(steps.Angle(readings.within.output().size()));
  AddAll(ScanTones(problem, residual, kMostTones), &peaks);
  AddRipples(problem, steps.Output(), readings.within.empty() ? nullptr : &readings, kMostRipples,
             &peaks);
  return Found(std::move(peaks));
}

}  // namespace gyrobench::calibration
