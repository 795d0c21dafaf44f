#include "calibration/trace/channel_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "calibration/signal/output_unit.h"
#include "calibration/trace/between_samples.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/channel_search.h"
#include "calibration/trace/held_out.h"
#include "calibration/trace/model_of_channel.h"
#include "calibration/trace/part_trial.h"
#include "calibration/trace/problem.h"
#include "calibration/trace/reference_angle_error.h"
#include "calibration/trace/remaining.h"
#include "calibration/trace/report_parts.h"
#include "calibration/trace/selection.h"
#include "calibration/trace/split.h"
#include "calibration/trace/timing_noise.h"

namespace gyrobench::calibration {
namespace {

constexpr Eigen::Index kLeastRows = 60;
constexpr double kLeastTime_s = 5.0;
// What tells an effect of a trace from its rivals.
std::string ResolvingManoeuvre(const std::string& id) {
  if (id.starts_with("composed(g*T")) return "hold the poses cold and hot";
  if (id.starts_with("composed")) return "vary one of the two quantities while the other stays";
  if (id.starts_with("empirical")) return "pass the same values again, at another time";
  return ManoeuvreOf(id);
}

std::string EquationOf(const Candidate& member) {
  if (member.effect != nullptr) {
    const std::string& equation = member.effect->equation;
    return equation.find("T0") == std::string::npos
               ? equation
               : fmt::format("{}, T0 = {:.2f} degC", equation, member.context.reference_degC);
  }
  if (member.empirical()) {
    return fmt::format("0 below {0} = {1:.4g}, c above {0} = {2:.4g}, straight between",
                       member.factors[0], member.knots[0], member.knots[1]);
  }
  std::vector<std::string> products;
  for (std::size_t k = 0; k < member.factors.size(); k += 2) {
    std::string product = "c";
    for (std::size_t f = k; f < k + 2; ++f) {
      const bool found = member.origin && member.factors[f] == member.origin->of;
      product += found ? fmt::format(" ({} - {})", member.factors[f], member.origin->parameter())
                 : member.offsets[f] == 0.0
                     ? " " + member.factors[f]
                     : fmt::format(" ({} - {:.4g})", member.factors[f], member.offsets[f]);
    }
    products.push_back(product);
  }
  return fmt::format("{}", fmt::join(products, " + "));
}

}  // namespace

class ChannelTracer::State {
 public:
  explicit State(const ChannelRequest& request)
      : request_(request),
        problem_(request.histories, request.channel, request.units_per_deg_s, request.angle_errors,
                 request.misread) {
    trace_.axis = static_cast<SensorAxis>(request.channel);
    model_.axis = trace_.axis;
    model_.unit = OutputUnit(request_.histories.front().recording->info);
    model_.units_per_deg_s = request_.units_per_deg_s;
    enough_data_ = EnoughData();
    if (!enough_data_) return;
    baseline_ = problem_.MakeBaseline();
    RemarkOnBaseline();
    RemarkOnMisreadAxes();
    candidates_ = std::make_shared<const CandidateSet>(
        AllCandidates(problem_, request_.covariates, request_.earth_rate_known,
                      CandidatesOf(problem_, request_.told)));
    if (!Finite()) return;
    if (std::string says = AddTimingNoise(baseline_, *candidates_, &problem_); !says.empty())
      trace_.remarks.push_back(std::move(says));
    if (std::string says = AddRoundingNoise(baseline_, *candidates_, &problem_); !says.empty())
      trace_.remarks.push_back(std::move(says));
    sampling_mend_.emplace(baseline_, *candidates_, &problem_);
  }

  std::optional<SamplingSeen> LookAtSamples() const {
    if (!sampling_mend_ || !sampling_mend_->MayTell()) return std::nullopt;
    return sampling_mend_->Look();
  }
  void MendBetweenSamples(const Sampling& sampling) {
    sampling_ = sampling;
    if (!sampling_mend_) return;
    if (std::string says = sampling_mend_->Mend(sampling); !says.empty())
      trace_.remarks.push_back(std::move(says));
    sampling_mend_.reset();
  }

  std::vector<std::function<void()>> Searches() {
    if (!enough_data_) return {};
    std::vector<std::function<void()>> out = {[this] { SearchAll(); }};
    if (!request_.try_on_rest || !Finite()) return out;
    auto add = [&](std::optional<Split> split, std::shared_ptr<const TrainedPart>* trained) {
      if (!split) return;
      out.push_back([this, split = std::move(*split), trained] {
        *trained = Train(problem_, baseline_, *candidates_, request_, split);
      });
    };
    add(EveryThirdBlock(problem_, baseline_), &blocks_);
    add(FirstPart(problem_, baseline_), &first_part_);
    return out;
  }

  TracedChannel Finish() {
    if (fit_) {
      FillHeldOut();
      Decide();
    } else if (enough_data_) {
      trace_.summary = "Not traced: " + trace_.remarks.back() + ".";
    }
    return {
        std::move(trace_),       std::move(model_),   std::move(row_), std::move(bench_findings_),
        std::move(angle_error_), std::move(misread_), sampling_};
  }

 private:
  void SearchAll() {
    const std::optional<SearchedChannel> found =
        SearchChannel(problem_, baseline_, candidates_, request_, &trace_.remarks);
    if (!found) return;
    fit_ = FitChannel(problem_, baseline_, found->selection);
    Fill(found->selection, found->noise, *fit_);
    effects_ = NamedEffects(found->selection, *fit_);
    bench_findings_ = FindingsOf(problem_, found->selection.members(), *fit_);
    angle_error_ = ReferenceAngleErrorOf(problem_, found->selection.members(), *fit_);
    misread_ = MisreadAxesOf(problem_, found->selection.members(), *fit_);
  }

  bool Finite() const { return baseline_.columns.allFinite() && problem_.output_deg().allFinite(); }

  bool EnoughData() {
    double time_s = 0.0;
    for (const Interval& interval : problem_.intervals()) time_s += interval.duration_s;
    if (problem_.rows() >= kLeastRows && time_s >= kLeastTime_s) return true;
    const bool none = request_.histories.front().recording->info.reference == ReferenceKind::kNone;
    const std::string lacks = fmt::format(
        "{:.3g} s of usable data{}, at least {:.0f} s and {} intervals of 0.1 s are needed", time_s,
        none ? " at rest" : "", kLeastTime_s, kLeastRows);
    trace_.remarks.push_back(lacks + ": not traced");
    trace_.summary = fmt::format("Not traced: {}.", lacks);
    return false;
  }

  void RemarkOnBaseline() {
    const unsigned observables = problem_.observables();
    auto without = [&](unsigned need, const std::string& says) {
      if ((observables & need) == 0) trace_.remarks.push_back(says);
    };
    without(kNeedsRate,
            problem_.TurnsWithOthersAlone()
                ? "this axis turned only together with another: its scale factor is taken as "
                  "nominal, and what differs from that is in the cross-axis part; turn the table "
                  "about this axis as well"
                : "no motion about this axis: scale factor, nonlinearity and every effect "
                  "that needs motion cannot be estimated");
    without(kNeedsTemperature,
            "temperature is missing or constant within 1 degC: no effect that depends on it is "
            "looked for (a slope of the offset over less is the baseline's)");
    without(kNeedsGravity,
            "gravity in the sensor's frame is not known: no effect of it can be "
            "estimated");
  }

  void RemarkOnMisreadAxes() {
    for (const MisreadAxis& misread : request_.misread) {
      trace_.remarks.push_back(fmt::format(
          "another channel shows that the {} axis is read wrong by up to {:.2g} deg ({}): the "
          "directions from which the turns of the axes outside of it come are corrected for that, "
          "and what is not known of it is in the errors of the cross-axis parts",
          kTableAxisNames[misread.context.table_axis], misread.values.norm(), misread.effect->id));
    }
  }

  void Fill(const Selection& selection, const NoiseModel& noise, const ChannelFit& fit) {
    trace_.noise = noise;
    // Under a noise that is right the white residual has a size of 1; where it is larger, errors
    // grow with it.
    const double grow = std::max(1.0, fit.whitened_rms());
    FillBaseline(selection, fit, grow);
    trace_.fitted_whitened_rms.before = trace_.baseline.whitened_rms;
    trace_.fitted_whitened_rms.after = fit.whitened_rms();
    trace_.fitted_angle_rms_deg.before = trace_.baseline.angle_rms_deg;
    trace_.fitted_angle_rms_deg.after = AngleRms(fit.raw * fit.linear);
    for (std::size_t i = 0; i < selection.members().size(); ++i)
      FillEffect(selection, fit, i, grow);
    std::set<std::string> named;
    for (const TracedEffect& effect : trace_.effects) named.insert(effect.id);
    trace_.unidentifiable = Unidentifiables(problem_, selection, named, request_.earth_rate_known);
    trace_.remaining = WhatRemains(problem_, fit, request_.covariates);
    effect_of_term_ = FillModel({problem_, baseline_, selection, fit, request_.covariates},
                                trace_.baseline.parameters, &model_);
    row_ = MakeChannelRow(problem_, baseline_, selection, fit, grow);
    row_.unit = model_.unit;
    row_.units_per_deg_s = model_.units_per_deg_s;
    if (request_.curves) trace_.curves = MakeCurves(problem_, fit, selection, noise);
  }

  void FillBaseline(const Selection& selection, const ChannelFit& fit, double grow) {
    std::vector<ModelParameter>& parameters = trace_.baseline.parameters;
    Eigen::Index j = 0;
    for (const std::size_t axis : baseline_.turned) {
      const bool own = axis == request_.channel;
      parameters.push_back(
          Parameter(fit, j++,
                    own ? "scale_factor"
                        : fmt::format("cross_axis_{}{}", "xyz"[request_.channel], "xyz"[axis]),
                    "1", grow));
    }
    for (std::size_t k = 0; k < baseline_.constants; ++k) {
      parameters.push_back(Parameter(
          fit, j++,
          baseline_.constants > 1 ? fmt::format("zero_rate_offset_run_{}", problem_.first_number(k))
                                  : "zero_rate_offset",
          "deg/s", grow));
    }
    for (int k = 1; k <= baseline_.temperature_order; ++k) {
      parameters.push_back(Parameter(fit, j++, fmt::format("offset_temperature_{}", k),
                                     k == 1 ? "deg/s/degC" : fmt::format("deg/s/degC^{}", k),
                                     grow));
    }
    // c of c dw/dt: how the shape of the filter whose delay is declared differs from a pure delay.
    for (int k = 0; k < baseline_.filter_shapes; ++k)
      parameters.push_back(Parameter(fit, j++, "filter_shape", "s^2", grow));
    if (baseline_.temperature_order > 0) trace_.baseline.reference_degC = baseline_.reference_degC;
    const WhiteStore& store = selection.store();
    const Eigen::VectorXd coefficients = store.Solve(selection.baseline_columns());
    const Eigen::VectorXd left =
        store.output() - store.Take(selection.baseline_columns()) * coefficients;
    trace_.baseline.whitened_rms =
        std::sqrt(left.squaredNorm() / static_cast<double>(problem_.rows()));
    trace_.baseline.angle_rms_deg = AngleRms(baseline_.columns * coefficients);
  }

  double AngleRms(const Eigen::VectorXd& model_deg) const {
    return AngleWindows(problem_, problem_.output_deg() - model_deg, 0, problem_.rows()).rms();
  }

  // Of the blocks; the forecast's figure alone is of use.
  std::optional<PartTrial> TryOnRests() {
    if (first_part_) {
      trace_.forecast_angle_rms_deg =
          TryOnRest(*first_part_, effects_, request_.seed, RestOf::kForecast).all.angle_rms_deg;
    }
    if (!blocks_) return std::nullopt;
    PartTrial trial = TryOnRest(*blocks_, effects_, request_.seed, RestOf::kBetween);
    trace_.heldout_whitened_rms = trial.all.whitened_rms;
    trace_.heldout_angle_rms_deg = trial.all.angle_rms_deg;
    trace_.training_effects = trial.chosen;
    return trial;
  }

  // Of an effect on data that had no part in its choice; where the training part does not choose
  // it, on data that its coefficients did not see.
  void FillHeldOut() {
    const std::optional<PartTrial> trial = TryOnRests();
    for (std::size_t i = 0; i < effects_.size(); ++i) {
      TracedEffect& effect = trace_.effects[i];
      const bool tried = trial && trial->same[i];
      const HeldOutFigures figures =
          tried ? *trial->same[i] : HoldOut(problem_, *fit_, fit_->ColumnsOf(i), request_.seed);
      effect.chosen_on = tried ? ChosenOn::kTrainingPart : ChosenOn::kAllData;
      effect.heldout_whitened_rms = figures.whitened_rms;
      effect.heldout_angle_rms_deg = figures.angle_rms_deg;
    }
    for (std::size_t k = 0; k < model_.terms.size(); ++k)
      model_.terms[k].chosen_on = trace_.effects[effect_of_term_[k]].chosen_on;
  }

  void FillEffect(const Selection& selection, const ChannelFit& fit, std::size_t i, double grow) {
    const Candidate member = AsGiven(problem_, selection.members()[i]);
    TracedEffect effect;
    effect.id = member.id;
    effect.equation = EquationOf(member);
    if (member.effect != nullptr) {
      effect.owner = member.effect->owner;
      effect.cause = member.effect->cause;
    } else if (member.empirical()) {
      effect.origin = EffectOrigin::kEmpirical;
      effect.cause = "unknown: a jump or a bend in one quantity describes it";
    } else {
      effect.origin = EffectOrigin::kComposed;
      effect.cause = "not in the catalogue: a product of two quantities describes it";
    }
    effect.parameters = EffectParameters(member, fit, i, grow, request_.covariates);
    if (member.size_unknown()) TellOfHeldShape(fit, i, grow, &effect.parameters);
    effect.p_value = selection.PValue(i);
    effect.rivals = selection.Rivals(i);
    std::set<std::string> ways;
    for (const std::string& rival : effect.rivals) ways.insert(ResolvingManoeuvre(rival));
    if (!effect.rivals.empty()) ways.insert(ResolvingManoeuvre(effect.id));
    ways.erase("");
    effect.settled_by = fmt::format("{}", fmt::join(ways, "; "));
    trace_.effects.push_back(std::move(effect));
  }

  // Its coefficients' errors are those for a shape that may be another one.
  void TellOfHeldShape(const ChannelFit& fit, std::size_t i, double grow,
                       std::vector<ModelParameter>* parameters) const {
    for (ModelParameter& parameter : *parameters) parameter.std_error = parameter.bound = kMissing;
    parameters->push_back(LargestInData(problem_, fit, i, grow));
  }

  void Decide() {
    const bool speaks = !trace_.remaining.findings.empty();
    std::vector<std::string> names;
    for (const TracedEffect& effect : trace_.effects) {
      names.push_back(effect.rivals.empty()
                          ? effect.id
                          : fmt::format("{} (or {})", effect.id, fmt::join(effect.rivals, " or ")));
    }
    if (names.empty() && !speaks) {
      trace_.verdict = Verdict::kNone;
      trace_.summary = "Nothing beyond the baseline is to be seen.";
    } else if (names.empty()) {
      trace_.verdict = Verdict::kUnexplained;
      trace_.summary = fmt::format("Structure remains and no cause could be named: {}.",
                                   trace_.remaining.findings.front().says);
    } else {
      trace_.verdict = speaks ? Verdict::kPartlyExplained : Verdict::kExplained;
      trace_.summary = fmt::format("{} by {}: {}{}.", speaks ? "Partly explained" : "Explained",
                                   fmt::join(names, ", "), ErrorInWords(),
                                   speaks ? "; some structure remains" : "") +
                       ChosenOnAllOnly();
    }
    if (!request_.earth_rate_known) RemarkOnEarth();
  }

  void RemarkOnEarth() {
    const std::string says = LatitudeNeeded(trace_.effects);
    if (!says.empty()) trace_.summary += fmt::format(" {}.", says);
    trace_.remarks.push_back(
        !says.empty() ? says
                      : "Earth's rotation is not taken off (it takes the site's latitude and the "
                        "orientation of the sensor): 0.0042 deg/s at most pass for bias or "
                        "g-sensitivity");
  }

  std::string ErrorInWords() const {
    const HeldOut& held_out = trace_.heldout_angle_rms_deg;
    const bool tried = std::isfinite(held_out.after);
    const HeldOut& error = tried ? held_out : trace_.fitted_angle_rms_deg;
    return fmt::format(
        "the angle error of {} goes from {:.3g} to {:.3g} deg{}",
        tried ? "held-out data" : "the data that it was fitted to", error.before, error.after,
        tried && error.confirms_nothing() ? ", which does not confirm what is named" : "");
  }

  std::string ChosenOnAllOnly() const {
    std::vector<std::string> names;
    for (const TracedEffect& effect : trace_.effects) {
      if (effect.chosen_on == ChosenOn::kAllData) names.push_back(effect.id);
    }
    if (names.empty() || !std::isfinite(trace_.heldout_angle_rms_deg.after)) return "";
    return fmt::format(
        " Chosen on all data only, as the two thirds that the choice is tried with do not ask for "
        "it: {}.",
        fmt::join(names, ", "));
  }

  const ChannelRequest& request_;
  ChannelProblem problem_;
  bool enough_data_ = false;
  Baseline baseline_;
  std::shared_ptr<const CandidateSet> candidates_;
  std::optional<SamplingMend> sampling_mend_;  // until it is known what they are
  Sampling sampling_;
  ChannelTrace trace_;
  ChannelModel model_;
  std::vector<std::size_t> effect_of_term_;  // of the model
  ChannelRow row_;
  BenchFindings bench_findings_;
  std::shared_ptr<const ReferenceAngleError> angle_error_;
  std::vector<MisreadAxis> misread_;
  std::optional<ChannelFit> fit_;     // of all data
  std::vector<NamedEffect> effects_;  // the same
  std::shared_ptr<const TrainedPart> blocks_, first_part_;
};

ChannelTracer::ChannelTracer(const ChannelRequest& request)
    : state_(std::make_unique<State>(request)) {}
ChannelTracer::~ChannelTracer() = default;

std::optional<SamplingSeen> ChannelTracer::LookAtSamples() const { return state_->LookAtSamples(); }

void ChannelTracer::MendBetweenSamples(const Sampling& sampling) {
  state_->MendBetweenSamples(sampling);
}

std::vector<std::function<void()>> ChannelTracer::Searches() { return state_->Searches(); }

TracedChannel ChannelTracer::Finish() { return state_->Finish(); }

}  // namespace gyrobench::calibration
