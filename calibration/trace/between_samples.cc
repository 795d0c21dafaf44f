#include "calibration/trace/between_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/robust.h"
#include "calibration/gls/noise_search.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

double Rate(const ChannelProblem& problem, std::size_t row) {
  return problem.output_deg()(static_cast<Eigen::Index>(row)) / problem.intervals()[row].duration_s;
}

// N^2, from second differences of the rate where nothing moves, or of all where too little rests;
// NaN where there is too little of anything. Counts coarser than the noise hardly ever change.
double RoughWalk(const ChannelProblem& problem) {
  constexpr std::size_t kLeast = 30;
  const std::vector<Interval>& intervals = problem.intervals();
  std::vector<double> all, at_rest;
  for (std::size_t i = 2; i < intervals.size(); ++i) {
    if (!intervals[i].GoesOn() || !intervals[i - 1].GoesOn()) continue;
    const auto variance = [&](std::size_t k) { return 1.0 / intervals[k].duration_s; };
    const double second = Rate(problem, i) - 2.0 * Rate(problem, i - 1) + Rate(problem, i - 2);
    all.push_back(second * second / (variance(i) + 4.0 * variance(i - 1) + variance(i - 2)));
    if (intervals[i].still && intervals[i - 1].still && intervals[i - 2].still)
      at_rest.push_back(all.back());
  }
  std::vector<double>& squares = at_rest.size() < kLeast ? all : at_rest;
  if (squares.size() < kLeast) return kMissing;
  const double mean = Mean(squares);
  // Half of the squares of normal values are below 0.455.
  const double by_median = Median(std::move(squares)) / 0.455;
  return by_median > 0.1 * mean ? by_median : mean;
}

// Of each row: whether a corner of the motion is seen in it or in its neighbours.
std::vector<bool> HasCorner(const ChannelProblem& problem, double walk_deg2_s) {
  constexpr double kCorner = 16.0;  // times the median, and what white noise makes of it
  constexpr double kOfNoise = 4.0 / 1200.0;
  const std::vector<Interval>& intervals = problem.intervals();
  std::vector<double> usual, moving;
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    usual.push_back(problem.between(static_cast<Eigen::Index>(i)).corners_deg2 /
                    intervals[i].duration_s);
    if (!intervals[i].still) moving.push_back(usual.back());
  }
  if (moving.empty()) return std::vector<bool>(intervals.size(), false);
  const double limit = kCorner * std::max({Median(std::move(usual)), Median(std::move(moving)),
                                           kOfNoise * walk_deg2_s});
  std::vector<bool> out(intervals.size(), false);
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const auto goes_on = [&](Eigen::Index k) {
      return k > 0 && k < problem.rows() && intervals[static_cast<std::size_t>(k)].GoesOn();
    };
    double seen = 0.0, time_s = 0.0;
    for (Eigen::Index k = goes_on(i) ? i - 1 : i; k <= (goes_on(i + 1) ? i + 1 : i); ++k) {
      seen += problem.between(k).corners_deg2;
      time_s += intervals[static_cast<std::size_t>(k)].duration_s;
    }
    out[static_cast<std::size_t>(i)] = seen > limit * time_s;
  }
  return out;
}

// Of each row: whether the rate changes in it or beside it by more than noise.
std::vector<bool> Accelerates(const ChannelProblem& problem, double walk_deg2_s) {
  constexpr double kSquare = 36.0;  // of its standard deviations
  const std::vector<Interval>& intervals = problem.intervals();
  std::vector<bool> out(intervals.size(), false);
  for (std::size_t i = 1; i + 1 < intervals.size(); ++i) {
    if (!intervals[i].GoesOn() || !intervals[i + 1].GoesOn()) continue;
    const double change_deg_s = Rate(problem, i + 1) - Rate(problem, i - 1);
    const double variance =
        walk_deg2_s * (1.0 / intervals[i + 1].duration_s + 1.0 / intervals[i - 1].duration_s);
    if (change_deg_s * change_deg_s > kSquare * variance) out[i - 1] = out[i] = out[i + 1] = true;
  }
  return out;
}

// The least of a curve through a share and its neighbours, a factor apart, in the logarithm; the
// share itself where they do not say.
double Between(const std::array<double, 3>& deviance, double factor) {
  const double bend = deviance[0] - 2.0 * deviance[1] + deviance[2];
  const double shift =
      bend > 0.0 && std::isfinite(bend) ? 0.5 * (deviance[0] - deviance[2]) / bend : 0.0;
  return std::pow(factor, std::clamp(shift, -0.5, 0.5));
}

// What the output lacks between samples, by what the samples may be.
struct Corners {
  // Of each row, over N^2 [s]: what the variance of the output is larger by where the motion bends
  // more than noise, or a rate that bends all along, makes of it. Of samples that are rates of
  // single moments.
  Eigen::VectorXd open_s;
  // What the output of such samples lacks [deg] where the rate goes straight on either side of a
  // corner.
  Eigen::VectorXd bends_deg;
  // What it lacks [deg] where samples are means from half way to half way: AsMeans of the nodes at
  // which the rate changes. At others it would be the noise of the output again.
  Eigen::VectorXd means_deg;
  // The same of means over the interval before their times, beside that they are late.
  Eigen::VectorXd means_before_deg;
  // Whether `open_s` is more than little beside the angle random walk; whether it or `means_deg` is.
  bool open = false, matter = false;
};

Corners CornersOf(const ChannelProblem& problem) {
  // Of the angle random walk over all that moves: what is less does not change a result. Of one
  // interval.
  constexpr double kMatters = 0.02, kCounts = 0.05;
  const double walk_deg2_s = RoughWalk(problem);
  if (!(walk_deg2_s > 0.0)) return {};
  const std::vector<bool> has_corner = HasCorner(problem, walk_deg2_s),
                          accelerates = Accelerates(problem, walk_deg2_s);
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.rows());
  Corners out{none, none, none, none};
  double moving_s = 0.0;
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const Interval& interval = problem.intervals()[static_cast<std::size_t>(i)];
    moving_s += interval.still ? 0.0 : interval.duration_s;
    const ChannelProblem::Between between = problem.between(i);
    const auto accelerate = [&](Eigen::Index a, Eigen::Index b) {
      return accelerates[static_cast<std::size_t>(a)] || accelerates[static_cast<std::size_t>(b)];
    };
    if (accelerate(i, std::min(i + 1, problem.rows() - 1))) {
      out.means_deg(i) += between.end.as_means_deg;
      out.means_before_deg(i) += between.end.as_means_later_deg;
    }
    if (accelerate(std::max(i - 1, Eigen::Index{0}), i)) {
      out.means_deg(i) -= between.begin.as_means_deg;
      out.means_before_deg(i) -= between.begin.as_means_later_deg;
    }
    if (!has_corner[static_cast<std::size_t>(i)]) continue;
    out.bends_deg(i) = between.bends_deg;
    const double open_s = (between.corners_deg2 + between.steps_deg2) / walk_deg2_s;
    if (open_s > kCounts * interval.duration_s) out.open_s(i) = open_s;
  }
  out.open = out.open_s.sum() > kMatters * moving_s;
  out.matter = out.open || out.means_deg.squaredNorm() > kMatters * walk_deg2_s * moving_s;
  return out;
}

// A latency of half an interval of the samples.
struct LateByHalf {
  double late_s = 0.0, declared_s = 0.0;
  Eigen::VectorXd lacks_deg;       // of the output
  std::vector<RawColumns> beside;  // what may act beside it, but other delays
};

// Nothing where no latency is looked for, or where the measurements are not sampled alike.
std::optional<LateByHalf> LateByHalfOf(const Baseline& baseline, const CandidateSet& candidates,
                                       const ChannelProblem& problem) {
  constexpr double kAlike = 0.05;
  const auto latency = std::ranges::find_if(candidates.grid, [](const Candidate& candidate) {
    return candidate.is_delay() && candidate.effect->filter_shape;
  });
  if (latency == candidates.grid.end()) return std::nullopt;
  const Recording& first = *problem.histories().front().recording;
  const double late_s = 0.5 * first.median_interval_s;
  for (const StateHistory& history : problem.histories()) {
    const Recording& recording = *history.recording;
    if (!(std::fabs(0.5 * recording.median_interval_s - late_s) < kAlike * late_s)) return {};
    if (recording.info.gyro_delay_s != first.info.gyro_delay_s) return {};
  }
  Candidate late = *latency;
  late.context.nonlinear = {late_s};
  late.raw.reset();
  const Eigen::VectorXd per_s = ColumnsOf(problem, late, candidates.covariates).col(0);
  if (!per_s.allFinite()) return std::nullopt;
  return LateByHalf{late_s, first.info.gyro_delay_s, -late_s * per_s,
                    EverythingThatMayAct(baseline, candidates, false)};
}

class CornerMend {
 public:
  CornerMend(Corners corners, std::vector<RawColumns> columns, std::optional<LateByHalf> late,
             ChannelProblem* problem)
      : problem_(*problem),
        corners_(std::move(corners)),
        columns_(std::move(columns)),
        late_(std::move(late)) {}

  void Mend() {
    const Lack means = LackOf(corners_.means_deg, columns_);
    const Lack before = MeansBefore();
    const Lack bends = corners_.open ? LackOf(corners_.bends_deg, columns_) : Lack{};
    // Noise that the output and its means have in common makes the share less than it is; half of
    // it is no way of sampling.
    const auto are = [&](const Lack& lack, const Lack& other) {
      const double rival = other.share > kWhole ? other.sigmas : 0.0;
      return lack.share > kWhole && lack.sigmas > std::max(rival, bends.sigmas);
    };
    if (are(means, before)) {
      samples_ = Samples::kMeans;
      correction_deg_ = corners_.means_deg;
      noise_ = means.noise;
    } else if (are(before, means)) {
      samples_ = Samples::kMeansBefore;
      // That they are late is left to the latency, which is an effect where nothing declares it.
      correction_deg_ = corners_.means_before_deg;
      noise_ = before.noise;
      columns_ = BesideLate(late_->lacks_deg);
    } else {
      correction_deg_ = bends.share * corners_.bends_deg;
      noise_ = bends.noise;
    }
    problem_.AddOutput(correction_deg_);
    if (!corners_.open) return;
    FitNoise();
    problem_.SetIntervals(WithNoise(at_nodes_, walk_));
  }

  std::string Says() const {
    constexpr double kBesideNoise = 0.5;
    const bool certain = at_nodes_ + walk_ == 0.0;
    if (samples_ == Samples::kMeansBefore) {
      return fmt::format(
          "its samples are means over the interval before their times, as the motion shows, and so "
          "late by half of it, {:.3g} ms: where its unit or its logger averages, declare that by "
          "gyro_delay_s = {:.3g}, and only a latency beyond it is an effect{}",
          1e3 * late_->late_s, late_->declared_s + late_->late_s,
          certain
              ? ""
              : "; how far it turned beside the ends of ramps is not known for certain, and the "
                "errors allow for that");
    }
    if (samples_ == Samples::kMeans && certain)
      return "its samples are means from half way to half way between their times, as the motion "
             "shows: their sum is how far it turned";
    double moved = 0.0, beside = 0.0, most_deg = 0.0, interval_s = 0.0;
    const double walk_deg2_s = noise_ ? std::pow(noise_->angle_random_walk_deg_sqrt_s, 2) : 0.0;
    for (Eigen::Index i = 0; i < problem_.rows(); ++i) {
      if (corners_.open_s(i) == 0.0) continue;
      const double square =
          std::pow(correction_deg_(i), 2) + walk_deg2_s * (at_nodes_ + walk_) * corners_.open_s(i);
      moved += square;
      beside += walk_deg2_s * problem_.intervals()[static_cast<std::size_t>(i)].duration_s;
      most_deg = std::max(most_deg, std::sqrt(square));
      interval_s = std::max(interval_s, problem_.history(i).recording->median_interval_s);
    }
    if (!(moved > kBesideNoise * beside)) return "";
    return fmt::format(
        "the gyro is sampled every {:.3g} s, seldom for such motion: how far it turned where a "
        "ramp begins or ends between two samples, up to {:.1g} deg, {}; log the gyro faster, or "
        "turn it with gentler ramps, to see smaller effects",
        interval_s, most_deg,
        certain ? "is taken from how its samples go on either side"
                : "is not known for certain, and the errors allow for that");
  }

 private:
  // What the corners leave open of the turn up to a node, which the next row takes back, and of that
  // from row to row.
  void FitNoise() {
    at_nodes_ = BestShare([&](double share) { return WithNoise(share, 0.0); });
    walk_ = BestShare([&](double share) { return WithNoise(at_nodes_, share); });
  }

  // The rows with shares of what samples of moments leave open, as noise of the nodes and as walk.
  // That of a node between rest and motion is walk of the row that moves: the angle of a rest is
  // that of all its readings.
  std::vector<Interval> WithNoise(double at_nodes, double walk) const {
    std::vector<Interval> out = problem_.intervals();
    const auto open_s = [&](std::size_t i) {
      return corners_.open_s(static_cast<Eigen::Index>(i));
    };
    for (std::size_t i = 0; i < out.size(); ++i) out[i].more_walk_s = walk * open_s(i);
    for (std::size_t i = 0; i + 1 < out.size(); ++i) {
      if (!out[i + 1].GoesOn()) continue;
      const double node_s = 0.5 * at_nodes * (open_s(i) + open_s(i + 1));
      if (!out[i].still && !out[i + 1].still)
        out[i].end_reference_walk_s -= node_s;
      else
        out[out[i].still ? i + 1 : i].more_walk_s += node_s;
    }
    return out;
  }

  // From none up to the first least, by the restricted deviance, each with the noise that suits it
  // best; the largest where the data want more.
  double BestShare(const std::function<std::vector<Interval>(double)>& with) {
    constexpr double kLeastShare = 1.0 / 64.0, kMostShare = 64.0, kFactor = 4.0, kLeastGain = 2.0;
    struct Tried {
      double share = 0.0, deviance = std::numeric_limits<double>::infinity();
      std::optional<NoiseModel> noise;
    };
    const auto try_from = [&](const Tried& last, double share) -> Tried {
      const NoiseSearch search(with(share), columns_, problem_.output_deg(), kNearlyDependent);
      const std::optional<NoiseEstimate> best = search.Best(last.noise, kRough);
      if (!best) return {share, std::numeric_limits<double>::infinity(), last.noise};
      return {share, best->deviance, best->noise};
    };
    const Tried none = try_from({0.0, 0.0, noise_}, 0.0);
    if (!std::isfinite(none.deviance)) return 0.0;
    noise_ = none.noise;
    Tried before = none, here = none, after = try_from(none, kLeastShare);
    while (after.deviance < here.deviance) {
      before = std::exchange(here, after);
      if (!(here.share < kMostShare)) break;
      after = try_from(here, kFactor * here.share);
    }
    if (!(here.deviance < none.deviance - kLeastGain)) return 0.0;
    noise_ = here.noise;
    // No share is no factor below the least.
    const bool between = before.share > 0.0 && after.share > here.share;
    return between ? here.share * Between({before.deviance, here.deviance, after.deviance}, kFactor)
                   : here.share;
  }

  // How much of a correction the data ask for, 0 to 1, and how clearly; 0 where they ask for none,
  // or for one that no way of sampling makes.
  struct Lack {
    double share = 0.0, sigmas = 0.0;
    std::optional<NoiseModel> noise;
  };
  std::vector<RawColumns> BesideLate(const Eigen::VectorXd& column_deg) const {
    std::vector<RawColumns> columns = late_->beside;
    columns.emplace_back(Eigen::MatrixXd(column_deg));
    return columns;
  }
  // None unless the data want that latency as well, from 0.8 of it up to the largest of shares.
  Lack MeansBefore() const {
    constexpr double kLate = 0.8;
    if (!late_) return {};
    const Lack before = LackOf(corners_.means_before_deg, BesideLate(late_->lacks_deg));
    if (before.sigmas == 0.0) return {};
    const Lack late = LackOf(late_->lacks_deg, BesideLate(corners_.means_before_deg));
    return late.share > kLate ? before : Lack{};
  }
  Lack LackOf(const Eigen::VectorXd& correction_deg, const std::vector<RawColumns>& beside) const {
    constexpr double kSigmas = 4.0, kMost = 1.5;
    if (correction_deg.isZero()) return {};
    std::vector<RawColumns> columns = {RawColumns(Eigen::MatrixXd(-correction_deg))};
    columns.insert(columns.end(), beside.begin(), beside.end());
    const NoiseSearch search(problem_.intervals(), columns, problem_.output_deg(),
                             kNearlyDependent);
    const std::optional<NoiseEstimate> best = search.Best({}, kRough);
    if (!best) return {};
    const CoefficientEstimate share = search.FirstCoefficient(best->noise);
    const double sigmas = share.value / share.std_error;
    if (!(sigmas > kSigmas) || !(share.value < kMost)) return {0.0, 0.0, best->noise};
    return {std::min(share.value, 1.0), sigmas, best->noise};
  }

  static constexpr double kWhole = 0.7;
  static constexpr double kRough = 0.1;  // of the logarithms of the noise's ratios

  ChannelProblem& problem_;
  const Corners corners_;
  std::vector<RawColumns> columns_;
  const std::optional<LateByHalf> late_;
  std::optional<NoiseModel> noise_;
  Eigen::VectorXd correction_deg_;
  enum class Samples { kMoments, kMeans, kMeansBefore } samples_ = Samples::kMoments;
  double at_nodes_ = 0.0, walk_ = 0.0;
};

}  // namespace

std::string MendBetweenSamples(const Baseline& baseline, const CandidateSet& candidates,
                               ChannelProblem* problem) {
  Corners corners = CornersOf(*problem);
  if (!corners.matter) return "";
  CornerMend mend(std::move(corners), EverythingThatMayAct(baseline, candidates),
                  LateByHalfOf(baseline, candidates, *problem), problem);
  mend.Mend();
  return mend.Says();
}

}  // namespace gyrobench::calibration
