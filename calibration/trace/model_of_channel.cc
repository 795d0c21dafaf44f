#include "calibration/trace/model_of_channel.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "calibration/trace/channel_fit.h"
#include "calibration/trace/selection.h"

namespace gyrobench::calibration {
namespace {

// A composed effect of several products is as many terms.
std::vector<ModelTerm> TermsOf(const FittedChannel& channel, std::size_t index) {
  const ChannelFit& fit = channel.fit;
  const Candidate member = AsGiven(channel.problem, channel.selection.members()[index]);
  const std::vector<Eigen::Index> columns = fit.ColumnsOf(index);
  ModelTerm term;
  term.reference_degC = member.context.reference_degC;
  term.id = member.id;
  if (member.empirical()) {
    term.origin = EffectOrigin::kEmpirical;
    term.factors = member.factors;
    term.knots = member.knots;
    term.coefficients = {0.0, fit.linear(columns[0])};
    return {term};
  }
  if (member.effect == nullptr) {
    std::vector<ModelTerm> terms;
    term.origin = EffectOrigin::kComposed;
    for (std::size_t k = 0; k < columns.size(); ++k) {
      term.factors = {member.factors[2 * k], member.factors[2 * k + 1]};
      term.offsets = {member.offsets[2 * k], member.offsets[2 * k + 1]};
      term.coefficients = {fit.linear(columns[k])};
      terms.push_back(term);
    }
    return terms;
  }
  for (std::size_t k = 0; k < columns.size(); ++k)
    term.coefficients.push_back(fit.values(fit.member_begin[index] + static_cast<Eigen::Index>(k)));
  term.id = member.effect->id;
  term.owner = member.effect->owner;
  term.nonlinear = member.context.nonlinear;
  term.table_axis = member.context.table_axis;
  if ((member.effect->needs & kNeedsCovariate) != 0) {
    term.covariate = channel.covariates[member.context.covariate];
    term.covariate_mean = member.context.covariate_mean;
  }
  return {term};
}

// In the order of ChannelFit::values.
void AppendNames(const Candidate& member, std::vector<std::string>* names) {
  if (member.effect == nullptr) {
    for (std::size_t k = 0; k < member.columns.size(); ++k)
      names->push_back(fmt::format("{}.{}", member.id, k));
    if (member.shape_is_free()) names->push_back(member.id + "." + member.origin->parameter());
    return;
  }
  for (const EffectTerm& term : member.effect->terms)
    names->push_back(member.id + "." + term.name + member.suffix);
  if (!member.shape_is_free()) return;
  for (const NonlinearParameter& parameter : member.effect->nonlinear)
    names->push_back(member.id + "." + parameter.name + member.suffix);
}

}  // namespace

Candidate AsGiven(const ChannelProblem& problem, Candidate member) {
  if (!member.of_one_run()) return member;
  double& run = member.context.nonlinear.at(0);
  run = static_cast<double>(problem.number_of_run(static_cast<std::size_t>(run) - 1));
  return member;
}

std::vector<std::size_t> FillModel(const FittedChannel& channel,
                                   const std::vector<ModelParameter>& baseline,
                                   ChannelModel* model) {
  const ChannelFit& fit = channel.fit;
  Eigen::Index j = 0;
  for (const std::size_t axis : channel.baseline.turned) {
    model->m_row_std_error[axis] = std::sqrt(fit.covariance(j, j));
    model->m_row[axis] = fit.values(j++);
  }
  model->reference_degC = channel.baseline.reference_degC;
  // Of several power-ons the mean of their offsets.
  double sum = 0.0;
  for (std::size_t k = 0; k < channel.baseline.constants; ++k) sum += fit.values(j++);
  model->bias_deg_s.push_back(sum / static_cast<double>(channel.baseline.constants));
  for (int k = 0; k < channel.baseline.temperature_order; ++k)
    model->bias_deg_s.push_back(fit.values(j++));
  for (const ModelParameter& parameter : baseline) model->parameter_names.push_back(parameter.name);
  std::vector<std::size_t> effect_of_term;
  for (std::size_t i = 0; i < channel.selection.members().size(); ++i) {
    for (ModelTerm& term : TermsOf(channel, i)) {
      model->terms.push_back(std::move(term));
      effect_of_term.push_back(i);
    }
    AppendNames(channel.selection.members()[i], &model->parameter_names);
  }
  if (model->parameter_names.size() != static_cast<std::size_t>(fit.values.size())) {
    throw std::logic_error(fmt::format("{} names for {} parameters of a channel's model",
                                       model->parameter_names.size(), fit.values.size()));
  }
  model->covariance.assign(fit.covariance.data(), fit.covariance.data() + fit.covariance.size());
  model->min_temperature_degC = channel.problem.min_temperature_degC();
  model->max_temperature_degC = channel.problem.max_temperature_degC();
  model->max_rate_deg_s = channel.problem.max_rate_deg_s();
  return effect_of_term;
}

}  // namespace gyrobench::calibration
