#include "calibration/trace/between_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/gls/statistics.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/corners.h"
#include "calibration/trace/noise_share.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

// A sample that is stamped late looks like one that was lost.
bool StampsAreLate(const StateHistory& history) { return history.timing_error_s > 0.0; }

// How late means over the interval before their times are, and what is late with them.
class Lateness {
 public:
  // Nothing where no latency is looked for, or where the measurements are not sampled alike.
  static std::optional<Lateness> Of(const Baseline& baseline, const CandidateSet& candidates,
                                    const ChannelProblem& problem) {
    constexpr double kAlike = 0.05;
    const auto latency = std::ranges::find_if(candidates.grid, [](const Candidate& candidate) {
      return candidate.is_delay() && candidate.effect->filter_shape;
    });
    if (latency == candidates.grid.end()) return std::nullopt;
    const Recording& first = *problem.histories().front().recording;
    const double half_s = 0.5 * first.median_interval_s;
    for (const StateHistory& history : problem.histories()) {
      const Recording& recording = *history.recording;
      if (!(std::fabs(0.5 * recording.median_interval_s - half_s) < kAlike * half_s)) return {};
      if (recording.info.gyro_delay_s != first.info.gyro_delay_s) return {};
    }
    Lateness out(half_s, *latency);
    out.declared_s_ = first.info.gyro_delay_s;
    out.covariates_ = candidates.covariates;
    out.beside_ = EverythingThatMayAct(baseline, candidates, false);
    if (!out.Set(half_s, problem)) return std::nullopt;
    return out;
  }

  // Another latency than half of an interval, as of a bus beside it. False where it is none.
  bool Set(double late_s, const ChannelProblem& problem) {
    latency_.context.nonlinear = {late_s};
    latency_.raw.reset();
    late_s_ = late_s;
    lacks_deg_ = -late_s * ColumnsOf(problem, latency_, covariates_).col(0);
    return lacks_deg_.allFinite();
  }

  // Half of an interval; what is declared of it already; the latency of lacks_deg().
  double half_s() const { return half_s_; }
  double declared_s() const { return declared_s_; }
  double late_s() const { return late_s_; }
  // What the output lacks [deg] by that latency.
  const Eigen::VectorXd& lacks_deg() const { return lacks_deg_; }
  // `column_deg` and what may act beside a latency, but other delays.
  std::vector<RawColumns> Beside(const Eigen::VectorXd& column_deg) const {
    std::vector<RawColumns> columns = beside_;
    columns.emplace_back(Eigen::MatrixXd(column_deg));
    return columns;
  }

 private:
  Lateness(double half_s, Candidate latency) : half_s_(half_s), latency_(std::move(latency)) {}

  double half_s_ = 0.0, declared_s_ = 0.0, late_s_ = 0.0;
  Candidate latency_;
  std::vector<std::string> covariates_;
  Eigen::VectorXd lacks_deg_;
  std::vector<RawColumns> beside_;
};

}  // namespace

class SamplingMend::State {
 public:
  State(const Baseline& baseline, const CandidateSet& candidates, ChannelProblem* problem)
      : baseline_(baseline),
        candidates_(candidates),
        problem_(*problem),
        corners_(CornersOf(*problem)) {}

  bool MayTell() const {
    constexpr double kSigmas = 4.0;
    return corners_.squared_sigmas > kSigmas * kSigmas;
  }

  SamplingSeen Look() const {
    const std::vector<RawColumns> columns = EverythingThatMayAct(baseline_, candidates_);
    const Lack means = LackOf(corners_.means_deg, columns);
    const MeansBefore before = LookForMeansBefore();
    const Lack bends = LackOf(corners_.bends_deg, columns);
    // Bends of a smooth motion are no corners, and speak for moments all the same.
    const double moments = bends.share < Lack::kMost ? bends.sigmas : 0.0;
    const auto are = [&](const Lack& lack, const Lack& other) {
      return lack.clear && lack.sigmas > std::max(other.clear ? other.sigmas : 0.0, moments);
    };
    SamplingSeen seen;
    seen.std_error = means.std_error();
    if (are(means, before.lack)) {
      seen.sampling.samples = SamplesAre::kMeans;
    } else if (are(before.lack, means)) {
      seen.sampling = {SamplesAre::kMeansBefore, before.late_s};
    }
    seen.clear = seen.sampling.samples != SamplesAre::kMoments || bends.wanted();
    return seen;
  }

  void Mend(const Sampling& sampling) {
    samples_ = sampling.samples;
    if (samples_ == SamplesAre::kMoments && !corners_.open) return;
    columns_ = EverythingThatMayAct(baseline_, candidates_);
    if (samples_ == SamplesAre::kMeans) {
      correction_deg_ = corners_.means_deg;
    } else if (samples_ == SamplesAre::kMeansBefore) {
      // That they are late is left to the latency, which is an effect where nothing declares it.
      correction_deg_ = corners_.means_before_deg;
      late_ = Lateness::Of(baseline_, candidates_, problem_);
      if (late_ && late_->Set(sampling.late_s, problem_))
        columns_ = late_->Beside(late_->lacks_deg());
    } else {
      const Lack bends = LackOf(corners_.bends_deg, columns_);
      correction_deg_ = (bends.wanted() ? std::min(bends.share, 1.0) : 0.0) * corners_.bends_deg;
      noise_ = bends.noise;
    }
    problem_.AddOutput(correction_deg_);
    if (!corners_.open) return;
    FitNoise();
    problem_.SetIntervals(WithNoise(at_nodes_, walk_));
  }

  std::string Says() const {
    constexpr double kBesideNoise = 0.5;
    const bool means = samples_ != SamplesAre::kMoments;
    if (correction_deg_.size() == 0 || (means && !MayTell())) return "";
    const bool certain = at_nodes_ + walk_ == 0.0;
    if (samples_ == SamplesAre::kMeansBefore) {
      if (!late_) return "";
      return fmt::format(
          "its samples are means over the interval before their times, as the motion of the sensor "
          "shows, and so late by half of it, {:.3g} ms: where its unit or its logger averages, "
          "declare that by gyro_delay_s = {:.3g}, and only a latency beyond it is an effect{}",
          1e3 * late_->half_s(), late_->declared_s() + late_->half_s(),
          certain
              ? ""
              : "; how far it turned beside the ends of ramps is not known for certain, and the "
                "errors allow for that");
    }
    if (samples_ == SamplesAre::kMeans && certain)
      return "its samples are means from half way to half way between their times, as the motion "
             "of the sensor shows: their sum is how far it turned";
    if (std::ranges::any_of(problem_.histories(), &StampsAreLate)) return "";
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
    at_nodes_ = Share([&](double share) { return WithNoise(share, 0.0); });
    walk_ = Share([&](double share) { return WithNoise(at_nodes_, share); });
  }
  double Share(const RowsWithShare& with) {
    constexpr double kLeastGain = 2.0;
    const NoiseShare best = BestShare(with, columns_, problem_.output_deg(), noise_, kLeastGain);
    noise_ = best.noise;
    return best.share;
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

  // How much of a correction the data ask for, and how clearly.
  struct Lack {
    double share = 0.0, sigmas = 0.0;
    bool clear = false;  // as much as a way of sampling makes
    std::optional<NoiseModel> noise;
    // Whether they ask for it, and for no more than some way of sampling makes.
    bool wanted() const { return sigmas > kSigmas && share < kMost; }
    double std_error() const { return share / sigmas; }
    static constexpr double kSigmas = 4.0, kMost = 1.5;
  };
  Lack LackOf(const Eigen::VectorXd& correction_deg, const std::vector<RawColumns>& beside) const {
    // Noise that the output and its means have in common makes the share less than it is; half of
    // it is no way of sampling.
    constexpr double kWhole = 0.7;
    if (correction_deg.isZero()) return {};
    std::vector<RawColumns> columns = {RawColumns(Eigen::MatrixXd(-correction_deg))};
    columns.insert(columns.end(), beside.begin(), beside.end());
    NoiseSearch search(problem_.intervals(), columns, problem_.output_deg(), kNearlyDependent);
    const std::optional<NoiseEstimate> best = search.BestPlausible({}, kRough);
    if (!best) return {};
    const CoefficientEstimate share = search.FirstCoefficient(best->noise);
    Lack out{share.value, share.value / share.std_error, false, best->noise};
    out.clear = out.wanted() && out.share > kWhole;
    return out;
  }
  struct MeansBefore {
    Lack lack;
    double late_s = 0.0;
  };
  // None unless the data want a latency of half an interval as well, or more, as of a bus. One of
  // just that is hardly by chance: less of the means has to be seen beside it.
  MeansBefore LookForMeansBefore() const {
    constexpr double kLate = 0.8, kMostLate = 4.0, kSettled = 0.02, kJust = 0.05;
    constexpr double kShare = 0.5, kSigmas = 2.5;
    constexpr int kSteps = 4;
    std::optional<Lateness> late = Lateness::Of(baseline_, candidates_, problem_);
    if (!late || corners_.means_before_deg.isZero()) return {};
    const std::vector<RawColumns> beside = late->Beside(corners_.means_before_deg);
    bool settled = false;
    double error = 0.0;  // of the latency, of half an interval
    for (int step = 0; step < kSteps && !settled; ++step) {
      const Lack lack = LackOf(late->lacks_deg(), beside);
      const double late_s = lack.share * late->late_s();
      if (!(lack.sigmas > Lack::kSigmas) || !(late_s > kLate * late->half_s()) ||
          !(late_s < kMostLate * late->half_s()) || !late->Set(late_s, problem_))
        return {};
      error = lack.std_error() * late_s / late->half_s();
      settled = std::fabs(lack.share - 1.0) < kSettled;
    }
    if (!settled) return {};
    MeansBefore out{LackOf(corners_.means_before_deg, late->Beside(late->lacks_deg())),
                    late->late_s()};
    const double beyond = late->late_s() / late->half_s() - 1.0;
    const bool just = std::fabs(beyond) < kJust && error < 0.5 * kJust;
    out.lack.clear |= just && out.lack.share > kShare && out.lack.share < Lack::kMost &&
                      out.lack.sigmas > kSigmas;
    return out;
  }

  static constexpr double kRough = 0.1;  // of the logarithms of the noise's ratios

  const Baseline& baseline_;
  const CandidateSet& candidates_;
  ChannelProblem& problem_;
  const Corners corners_;
  std::vector<RawColumns> columns_;
  std::optional<Lateness> late_;
  std::optional<NoiseModel> noise_;
  Eigen::VectorXd correction_deg_;  // empty: nothing was done
  SamplesAre samples_ = SamplesAre::kMoments;
  double at_nodes_ = 0.0, walk_ = 0.0;
};

SamplingMend::SamplingMend(const Baseline& baseline, const CandidateSet& candidates,
                           ChannelProblem* problem)
    : state_(std::make_unique<State>(baseline, candidates, problem)) {}
SamplingMend::~SamplingMend() = default;

bool SamplingMend::MayTell() const { return state_->MayTell(); }
SamplingSeen SamplingMend::Look() const { return state_->Look(); }

std::string SamplingMend::Mend(const Sampling& sampling) {
  state_->Mend(sampling);
  return state_->Says();
}

}  // namespace gyrobench::calibration
