#include "calibration/trace/scans.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <unsupported/Eigen/FFT>
#include <utility>

#include "base/geometry.h"
#include "base/robust.h"
#include "calibration/effects/basis.h"
#include "calibration/gls/filled_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/gls/statistics.h"

namespace gyrobench::calibration {
namespace {

using Complex = std::complex<double>;

// Steps nearer to an end of a measurement than this are not told from its beginning.
constexpr Eigen::Index kEdgeRows = 20;
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

std::size_t PowerOfTwo(std::size_t least) {
  std::size_t size = 2;
  while (size < least) size *= 2;
  return size;
}

// First row of the longest power-on, and the one behind its last: where power-ons differ in their
// beginning a tone's phase is another.
std::pair<Eigen::Index, Eigen::Index> LongestPowerOn(const ChannelProblem& problem) {
  const std::vector<Eigen::Index>& begins = problem.power_on_begins();
  std::pair<Eigen::Index, Eigen::Index> longest = {0, 0};
  for (std::size_t k = 0; k < begins.size(); ++k) {
    const Eigen::Index end = k + 1 < begins.size() ? begins[k + 1] : problem.rows();
    if (end - begins[k] > longest.second - longest.first) longest = {begins[k], end};
  }
  return longest;
}

// Of a spectrum, up to half of its frequencies.
std::vector<double> PowerOf(const std::vector<double>& grid) {
  Eigen::FFT<double> fft;
  std::vector<Complex> spectrum;
  fft.fwd(spectrum, grid);
  std::vector<double> power;
  for (std::size_t f = 0; f < grid.size() / 2; ++f) power.push_back(std::norm(spectrum[f]));
  return power;
}

// Number of the frequency, from `slowest` on; `power`: of the rests at it. Short rests far from
// each other show several tones as clearly as the true one: of these it is the one that all rows
// show.
std::size_t StrongestTone(const std::vector<double>& at_rest, const std::vector<double>& all,
                          std::size_t slowest, double* power) {
  constexpr double kAsClear = 0.8;
  double most = 0.0;
  for (std::size_t f = slowest; f < at_rest.size(); ++f) most = std::max(most, at_rest[f]);
  std::size_t strongest = 0;
  for (std::size_t f = slowest; f < at_rest.size(); ++f) {
    if (at_rest[f] > kAsClear * most && (strongest == 0 || all[f] > all[strongest])) strongest = f;
  }
  *power = strongest > 0 ? at_rest[strongest] : 0.0;
  return strongest;
}

// The residual on a grid of the rows' usual length, its spectrum; all measurements add up.
ScanPeak Tone(const ChannelProblem& problem, const Eigen::VectorXd& residual) {
  ScanPeak peak;
  peak.effect = &ScannedEffect(Search::kFrequency, EffectDomain::kRateIntegral);
  constexpr Eigen::Index kLeastRest = 64;
  if (problem.rows() < kLeastRest) return peak;
  std::vector<double> lengths;
  for (const Interval& interval : problem.intervals()) lengths.push_back(interval.duration_s);
  const double step_s = Median(std::move(lengths));
  const auto [first, end] = LongestPowerOn(problem);
  // In motion a tone cannot be told from the ripple of a table that turns: what the channel feels
  // of no turn speaks. Of an orientation no ripple is known.
  auto rests = [&](Eigen::Index i) {
    constexpr double kUnfelt = 0.01;
    if (problem.history(i).recording->info.reference == ReferenceKind::kOrientation) return true;
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    return interval.still ||
           std::max(interval.begin_reference_share, interval.end_reference_share) < kUnfelt;
  };
  Eigen::Index resting = 0;
  for (Eigen::Index i = first; i < end; ++i) resting += rests(i) ? 1 : 0;
  // Of all rows: with less than a twentieth at rest no tone is seen, with less than a fifth it is a
  // last resort.
  constexpr Eigen::Index kLeastPart = 20, kFewPart = 5;
  if (resting < kLeastRest || kLeastPart * resting < end - first) return peak;
  peak.last_resort = kFewPart * resting < end - first;
  const double origin = problem.begin_s(first);
  const auto slots = static_cast<std::size_t>((problem.end_s(end - 1) - origin) / step_s) + 2;
  if (slots > (1u << 22)) return peak;
  const std::size_t size = PowerOfTwo(2 * slots);
  std::vector<double> at_rest(size, 0.0), all(size, 0.0);
  for (Eigen::Index i = first; i < end; ++i) {
    const auto slot = static_cast<std::size_t>(std::lround((problem.begin_s(i) - origin) / step_s));
    all[slot] += residual(i);
    if (rests(i)) at_rest[slot] += residual(i);
  }
  // Slower than five periods a measurement is drift.
  const auto slowest = static_cast<std::size_t>(5 * size / slots);
  const std::size_t f = StrongestTone(PowerOf(at_rest), PowerOf(all), slowest, &peak.gain);
  if (f > 0) peak.nonlinear = static_cast<double>(f) / (static_cast<double>(size) * step_s);
  // Relative to white noise of unit variance.
  peak.gain *= 2.0 / static_cast<double>(resting);
  peak.tried = static_cast<double>(slots);
  peak.row = first;
  return peak;
}

void AddRipples(const ChannelProblem& problem, const Eigen::VectorXd& output_score,
                const SingleReadings* readings, std::size_t most_of_an_axis,
                std::vector<ScanPeak>* peaks) {
  for (const std::size_t axis : problem.table_axes()) {
    for (const ScanPeak& peak : ScanRipple(problem, output_score, readings, axis, most_of_an_axis))
      peaks->push_back(peak);
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
  std::vector<ScanPeak> peaks = {steps.Bias(), Tone(problem, residual)};
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
  peaks.push_back(Tone(problem, residual));
  AddRipples(problem, steps.Output(), readings.within.empty() ? nullptr : &readings, kMostRipples,
             &peaks);
  return Found(std::move(peaks));
}

}  // namespace gyrobench::calibration
