#include "calibration/trace/channel_search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "calibration/gls/noise_search.h"
#include "calibration/gls/raw_columns.h"
#include "calibration/gls/scaled_ldlt.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/held_out.h"
#include "calibration/trace/remaining.h"
#include "calibration/trace/scans.h"

namespace gyrobench::calibration {
namespace {

constexpr int kPasses = 3;
// Of the logarithms of the noise's ratios, which so many rows tell to some tenths: more tell them
// better, by the root of their number, and a noise that is as rough as ever beside that would have
// all of the search made a second time.
constexpr double kRough = 0.1, kRowsOfRough = 2e4;
constexpr std::ptrdiff_t kCrowd = 3;
// Of the bias random walk: under so much of it steps and tones show that the whole of it hides.
constexpr double kLessWalk = 0.1;
// Square of a step of the angle in its standard errors: wild readings in a row make smaller ones.
constexpr double kClearStep = 200.0;
constexpr int kMostForWalk = 3;
// Of the chance of a false discovery.
constexpr double kShareForWalk = 0.01;
// So much more walk is another noise, however flat the likelihood is there, unless it is next to
// none beside the angle random walk.
constexpr double kMoreWalk = 1.5, kSomeWalk_per_s = 1e-3;
// Below this no stand's angle means anything: rounding and sampling are what is left.
constexpr double kLeastAngle_deg = 1e-3;
// Of the deviance: the noise by the chosen model is not the one by everything that may act (chi
// square of three degrees, about 0.7 %); two noises differ so little that it is no matter.
constexpr double kOtherNoise = 12.0, kSameNoise = 0.5;

class ChannelSearcher {
 public:
  ChannelSearcher(const ChannelProblem& problem, const Baseline& baseline,
                  std::shared_ptr<const CandidateSet> candidates, const ChannelRequest& request,
                  std::vector<std::string>* remarks)
      : problem_(problem),
        baseline_(baseline),
        request_(request),
        remarks_(*remarks),
        candidates_(std::move(candidates)),
        raw_baseline_(RawBaseline(baseline)) {}

  std::optional<SearchedChannel> Run() {
    saturated_ = EverythingThatMayAct(baseline_, *candidates_);
    for (Eigen::Index i = 0; i < problem_.rows(); ++i) {
      if (baseline_.columns.row(i).allFinite() && std::isfinite(problem_.output_deg()(i))) continue;
      remarks_.push_back(fmt::format(
          "{}: rate, temperature or output is no finite number from {:.3f} s to {:.3f} s: not "
          "traced; look at the table's rows there",
          problem_.history(i).name, problem_.begin_s(i), problem_.end_s(i)));
      return std::nullopt;
    }
    const std::optional<NoiseEstimate> first = Everything().BestPlausible({}, Rough());
    if (!first) {
      remarks_.push_back(fmt::format(
          "the noise cannot be estimated from {} intervals beside {} columns of the baseline and "
          "what else may act: not traced; measure for longer",
          problem_.rows(), baseline_.columns.cols()));
      return std::nullopt;
    }
    own_ = *first;
    TakeInWhatPassesForNoise();
    std::optional<SearchedChannel> found;
    found.emplace(SearchedChannel{candidates_, Select(own_.noise), own_.noise});
    if (BaselineIsPerfect(found->selection)) return found;
    for (int pass = 0; pass < kPasses; ++pass) {
      found->selection.Run();
      found->selection.JoinOrigins();
      DropDoubtful(&*found);
      found->selection.PlaceWhatIsLeft();
      const std::optional<NoiseModel> better = Reestimate(*found);
      if (!better || pass + 1 == kPasses) break;
      found.reset();  // its columns are the most of the memory: one store at a time
      found.emplace(SearchedChannel{candidates_, Select(*better), *better});
    }
    DropCrowd(&found->selection);
    if (DropUseless(&found->selection)) DropWhereResidualsCorrelate(&*found);
    found->selection.PlaceWhatIsLeft();
    DropUncertain(problem_, baseline_, &found->selection);
    DropWhatChanceMakes(&*found);
    found->selection.PlaceWhatIsLeft();
    for (const double at_s : found->selection.DropSpikes())
      remarks_.push_back(fmt::format(
          "at {:.2f} s a reading of the reference jumps, of an axis that this channel would feel "
          "turn and does not: no effect is named for it",
          at_s));
    const std::optional<NoiseModel> noise =
        NoiseWithRounding(problem_, baseline_, found->selection, found->noise);
    if (noise) {
      found.reset();
      found.emplace(SearchedChannel{candidates_, Select(*noise), *noise});
    }
    for (std::string& remark : RemarksOnHeldShapes(found->selection))
      remarks_.push_back(std::move(remark));
    return found;
  }

 private:
  double Rough() const {
    return kRough * std::sqrt(std::min(1.0, kRowsOfRough / static_cast<double>(problem_.rows())));
  }

  Selection Select(const NoiseModel& noise) const {
    return Selection(problem_, baseline_, noise, *candidates_,
                     SelectionOptions{request_.false_discovery});
  }

  // A step, a tone or a slow ripple, which have no grid, make the bias random walk look larger and
  // are then hidden by it. They are looked for under a smaller one; what is worth it under any
  // noise is known to the noise from then on. So is a clear step of the angle, which makes all
  // other noise look larger and the residuals of rest and motion unequal: their tails would then
  // forbid to believe it.
  void TakeInWhatPassesForNoise() {
    for (int round = 0; round < kMostForWalk; ++round) {
      const std::optional<Candidate> found = BestUnderLessWalk();
      if (!found) return;
      plain_.push_back(Raw(*found));
      AddToEverything(plain_.back());
      own_ = Everything().BestPlausible(own_.noise, Rough()).value_or(own_);
    }
  }

  std::optional<Candidate> BestUnderLessWalk() const {
    NoiseModel quiet = own_.noise;
    quiet.bias_random_walk_deg_s_sqrt_s *= kLessWalk;
    const Whitener whitener(problem_.intervals(), quiet);
    Eigen::MatrixXd model(problem_.rows(), 0), output = problem_.output_deg();
    for (const RawColumns& columns : plain_) AppendColumns(&model, columns.Copy());
    whitener.Apply(model);
    whitener.Apply(output);
    const Eigen::VectorXd residual = Projection(model).Off(output);
    std::optional<Candidate> best;
    double most = 0.0;
    for (const ScanPeak& peak : ScanForNoise(problem_, whitener, model, residual)) {
      if (peak.last_resort && best) continue;
      Candidate candidate = ScannedCandidate(problem_, peak);
      if (candidate.angle_step() && peak.gain < kClearStep) continue;
      const double level = std::log(request_.false_discovery * kShareForWalk / peak.tried);
      // What is not worth it under less of the walk is not under any.
      if (candidate.search() == Search::kPeriods && !peak.ComesNear(level)) continue;
      const double evidence_margin = level - LogChance(candidate);
      if (evidence_margin <= most) continue;
      most = evidence_margin;
      best = std::move(candidate);
    }
    return best;
  }

  // Of what it gains beside the baseline and what was taken in before, when each of both models has
  // the noise that suits it. With the whole grid beside it this would take as long as all the rest.
  double LogChance(const Candidate& candidate) const {
    std::vector<RawColumns> model = plain_;
    Eigen::Index column = 0;
    for (const RawColumns& columns : model) column += columns.cols();
    model.push_back(Raw(candidate));
    std::vector<Eigen::Index> group;
    for (Eigen::Index j = 0; j < model.back().cols(); ++j) group.push_back(column++);
    const NoiseSearch search(problem_.intervals(), model, problem_.output_deg(), kDependent,
                             PieceFor(candidate.search() == Search::kFrequency));
    return candidate.LogChance(search.GainsOverNoise({group}, own_.noise).front(),
                               static_cast<double>(group.size()));
  }

  // Tones would not outlive their sums over a second.
  static double PieceFor(bool tones) { return tones ? 0.0 : NoiseSearch::kPiece_s; }

  RawColumns Raw(const Candidate& candidate) const {
    return candidate.Limited(ColumnsOf(problem_, candidate, request_.covariates));
  }

  // Raw columns of the baseline and of the members.
  std::vector<RawColumns> ModelOf(const Selection& selection) const {
    std::vector<RawColumns> model = raw_baseline_;
    for (const Candidate& member : selection.members())
      model.push_back(member.raw ? *member.raw : Raw(member));
    return model;
  }

  NoiseSearch& Everything() {
    if (!everything_) {
      everything_.emplace(problem_.intervals(), saturated_, problem_.output_deg(),
                          kNearlyDependent);
    }
    return *everything_;
  }
  void AddToEverything(RawColumns columns) {
    saturated_.push_back(std::move(columns));
    everything_.reset();
  }

  // The grid has what it does, as far as the noise can tell.
  bool JudgedOnGrid(const Candidate& member, const NoiseModel& noise) const {
    if (member.effect == nullptr || !member.context.start_sides.empty()) return false;
    if (member.search() != Search::kCoefficient) return member.search() == Search::kNone;
    const auto point = std::ranges::find(candidates_->grid, member.family, &Candidate::family);
    if (point == candidates_->grid.end()) return false;
    Eigen::MatrixXd more = member.context.nonlinear[0] * (Raw(member).Copy() - point->raw->Copy());
    Whitener(problem_.intervals(), noise).Apply(more);
    return more.squaredNorm() < kOtherNoise;
  }

  // The noise of the chosen model, which has fewer columns and knows slow noise better, where the
  // model of everything that may act does not contradict it; else that model's own. nullopt where
  // it is the one that was used.
  std::optional<NoiseModel> Reestimate(const SearchedChannel& found) {
    bool outside = false;
    for (const Candidate& member : found.selection.members()) {
      // What the noise was not judged with makes it look larger than it is.
      if (JudgedOnGrid(member, found.noise) || !judged_.insert(member.family).second) continue;
      AddToEverything(Raw(member));
      outside = true;
    }
    NoiseSearch& everything = Everything();
    const NoiseSearch chosen(problem_.intervals(), ModelOf(found.selection), problem_.output_deg());
    std::optional<NoiseEstimate> better = chosen.Best(found.noise);
    if (outside) own_ = everything.BestPlausible(found.noise, Rough()).value_or(own_);
    if (!better) return std::nullopt;
    better = chosen.WithMeanWalk(*better);
    const bool agrees = everything.Deviance(better->noise) - own_.deviance < kOtherNoise;
    const NoiseSearch& by = agrees ? chosen : everything;
    const NoiseEstimate& best = agrees ? *better : own_;
    const double walk = best.noise.bias_random_walk_deg_s_sqrt_s;
    const bool more_walk = walk > kMoreWalk * found.noise.bias_random_walk_deg_s_sqrt_s &&
                           walk > kSomeWalk_per_s * best.noise.angle_random_walk_deg_sqrt_s;
    const bool same = std::fabs(by.Deviance(found.noise) - best.deviance) < kSameNoise;
    if (same && !more_walk) return std::nullopt;
    return best.noise;
  }

  // An effect stands only when noise of another size does not explain the data as well: a slow
  // effect and a random walk of the bias answer for the same.
  void DropDoubtful(SearchedChannel* found) const {
    while (!found->selection.members().empty()) {
      const std::vector<Candidate>& members = found->selection.members();
      SetGainsByAnyNoise(found);
      std::size_t weakest = members.size();
      double lack = 0.0;
      for (std::size_t i = 0; i < members.size(); ++i) {
        const auto degrees = static_cast<double>(members[i].columns.size());
        const double over =
            members[i].LogChance(members[i].gain_over_noise, degrees) - members[i].log_level;
        if (over <= lack) continue;
        lack = over;
        weakest = i;
      }
      if (weakest == members.size()) return;
      found->selection.Remove(weakest);
    }
  }

  // What passed beside others only that are gone by now.
  void DropWhatChanceMakes(SearchedChannel* found) const {
    constexpr double kByChance = 0.05;  // after correction for all that was tried
    const Selection& selection = found->selection;
    const auto most_by_chance = [&]() -> std::optional<std::size_t> {
      std::optional<std::size_t> most;
      double p = kByChance;
      for (std::size_t i = 0; i < selection.members().size(); ++i) {
        const double own = selection.PValue(i);
        if (!(own > p)) continue;
        p = own;
        most = i;
      }
      return most;
    };
    while (most_by_chance()) {
      SetGainsByAnyNoise(found);  // those that are gone were beside them before
      const std::optional<std::size_t> most = most_by_chance();
      if (!most) return;
      found->selection.Remove(*most);
    }
  }

  void SetGainsByAnyNoise(SearchedChannel* found) const {
    const std::vector<double> worth = GainsOverNoise(*found);
    for (std::size_t i = 0; i < worth.size(); ++i) {
      // Single readings know nothing of the gyro's noise.
      const double gain = worth[i] + found->selection.GainByReadings(i);
      found->selection.SetGainByAnyNoise(i, gain);
    }
  }

  // What each member gains when each of both models has the noise that suits it.
  std::vector<double> GainsOverNoise(const SearchedChannel& found) const {
    const std::vector<Candidate>& members = found.selection.members();
    std::vector<std::vector<Eigen::Index>> groups;
    Eigen::Index column = baseline_.columns.cols();
    bool fast = false;
    for (const Candidate& member : members) {
      groups.emplace_back();
      for (std::size_t k = 0; k < member.columns.size(); ++k) groups.back().push_back(column++);
      fast = fast || member.search() == Search::kFrequency;
    }
    const NoiseSearch search(problem_.intervals(), ModelOf(found.selection), problem_.output_deg(),
                             kDependent, PieceFor(fast));
    return search.GainsOverNoise(groups, found.noise);
  }

  // Steps and tones that come in crowds describe a residual without explaining it.
  void DropCrowd(Selection* selection) {
    auto crowds = [](const Candidate& member) {
      return member.effect != nullptr && member.effect->of_one_time();
    };
    const std::vector<Candidate>& members = selection->members();
    if (std::count_if(members.begin(), members.end(), crowds) < kCrowd) return;
    for (std::size_t i = members.size(); i-- > 0;) {
      if (crowds(members[i])) selection->Remove(i);
    }
    remarks_.push_back(
        "many steps or tones would each describe a part of what is left: none of them is named");
  }

  // By how much a member makes data that the fit did not see less likely. Larger errors there, and
  // larger beyond chance, are harm whatever the model says of them. What acts in the held-out rows
  // alone, as a step of the angle, is not judged by this: no other rows foretell it.
  static double Harm(const HeldOutFigures& figures, const Candidate&) {
    const bool worse = figures.whitened_rms.reduction_ci95[1] < 0.0;
    return worse ? std::max(-figures.foretold_better, 0.0) : -figures.foretold_better;
  }
  // The same of the angle error, where it is somewhat larger, and beyond what noise does. Windows
  // of the angle hardly show what is fast, and beside flicker they are not independent: of a tone
  // they count where the whitened error falls by a smaller part than they grow.
  static double HarmOfAngle(const HeldOutFigures& figures, const Candidate& member) {
    constexpr double kSomewhat = 0.005;
    const HeldOut& angle = figures.angle_rms_deg;
    const HeldOut& white = figures.whitened_rms;
    const bool tone = member.search() == Search::kFrequency;
    const double least = tone ? std::fmax(kSomewhat, 1.0 - white.after / white.before) : kSomewhat;
    const double more = angle.after / angle.before - 1.0;
    return more > least && angle.reduction_ci95[1] < 0.0 ? more : -1.0;
  }

  // What does not help on data that the fit did not see is not kept, whatever its p-value: what
  // makes nothing better is no finding either.
  template <typename HarmOf>
  bool DropMostHarmful(Selection* selection, HarmOf harm_of, bool readings_tell = false) const {
    if (selection->members().empty()) return false;
    const ChannelFit fit = FitChannel(problem_, baseline_, *selection);
    std::size_t worst = selection->members().size();
    double harm = 0.0;
    for (std::size_t i = 0; i < selection->members().size(); ++i) {
      // Of what single readings have confirmed the means that are held out may know nothing.
      if (readings_tell && selection->ReadingsConfirm(i)) continue;
      const double own =
          harm_of(HoldOut(problem_, fit, fit.ColumnsOf(i), request_.seed), selection->members()[i]);
      if (!(own >= harm)) continue;
      harm = own;
      worst = i;
    }
    if (worst == selection->members().size()) return false;
    selection->Remove(worst);
    return true;
  }

  // Whether structure is left.
  bool DropUseless(Selection* selection) const {
    while (DropMostHarmful(selection, Harm, true)) {
    }
    if (selection->members().empty()) return false;
    // Where structure is left an effect may have been fitted to a part of it.
    const ChannelFit fit = FitChannel(problem_, baseline_, *selection);
    const ChannelTrace::Remaining remains = WhatRemains(problem_, fit, request_.covariates);
    if (remains.white && remains.findings.empty()) return false;
    while (DropMostHarmful(selection, HarmOfAngle)) {
    }
    return true;
  }

  // Beside a residual that is not white an effect must reach its level with errors that allow for
  // that: those of a slow effect are larger there than a white residual would have them.
  void DropWhereResidualsCorrelate(SearchedChannel* found) const {
    Selection& selection = found->selection;
    const RowsTogether together = FindRowsTogether(problem_);
    while (!selection.members().empty()) {
      const ChannelFit fit = FitChannel(problem_, baseline_, selection);
      if (WhatRemains(problem_, fit, request_.covariates).white) return;
      std::vector<double> gains;
      std::size_t weakest = selection.members().size();
      double lack = 0.0;
      for (std::size_t i = 0; i < selection.members().size(); ++i) {
        const Candidate& member = selection.members()[i];
        CorrelatedGain least = LeastWhereCorrelated(problem_, together, fit, fit.ColumnsOf(i));
        // Single readings are independent of each other.
        least.gain += selection.GainByReadings(i);
        least.gain = std::min(least.gain, member.gain_over_noise);
        gains.push_back(least.gain);
        const double over = member.LogChance(least.gain, least.rank) - member.log_level;
        if (over <= lack) continue;
        lack = over;
        weakest = i;
      }
      if (weakest == selection.members().size()) {
        for (std::size_t i = 0; i < gains.size(); ++i) selection.SetGainByAnyNoise(i, gains[i]);
        return;
      }
      selection.Remove(weakest);
      // What explained the same as the one that is gone gains more now.
      SetGainsByAnyNoise(found);
    }
  }

  bool BaselineIsPerfect(const Selection& selection) {
    const Eigen::VectorXd residual =
        problem_.output_deg() -
        baseline_.columns * selection.store().Solve(selection.baseline_columns());
    const double rms = AngleWindows(problem_, residual, 0, problem_.rows()).rms();
    if (!(rms < kLeastAngle_deg)) return false;
    remarks_.push_back(fmt::format(
        "the baseline leaves an angle error of {:.2g} deg, less than sampling and rounding do: "
        "nothing is looked for in it",
        rms));
    return true;
  }

  const ChannelProblem& problem_;
  const Baseline& baseline_;
  const ChannelRequest& request_;
  std::vector<std::string>& remarks_;
  std::shared_ptr<const CandidateSet> candidates_;
  // The second with what passed for bias random walk.
  std::vector<RawColumns> raw_baseline_, plain_ = raw_baseline_;
  std::vector<RawColumns> saturated_;      // the baseline and what else may act
  std::optional<NoiseSearch> everything_;  // of these
  NoiseEstimate own_;                      // by `saturated_`
  std::set<std::string> judged_;           // families beyond the grid that `saturated_` has
};

}  // namespace

std::optional<SearchedChannel> SearchChannel(const ChannelProblem& problem,
                                             const Baseline& baseline,
                                             std::shared_ptr<const CandidateSet> candidates,
                                             const ChannelRequest& request,
                                             std::vector<std::string>* remarks) {
  return ChannelSearcher(problem, baseline, std::move(candidates), request, remarks).Run();
}

}  // namespace gyrobench::calibration
