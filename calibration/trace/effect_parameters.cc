#include <cmath>

#include "base/geometry.h"
#include "calibration/effects/factor.h"
#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"
#include "calibration/trace/report_parts.h"

namespace gyrobench::calibration {
namespace {

// sin and cos as amplitude and phase: a sin(x + p) = a cos p sin x + a sin p cos x.
std::vector<ModelParameter> AmplitudeAndPhase(const ChannelFit& fit, Eigen::Index j,
                                              const std::string& suffix, const std::string& unit,
                                              double grow) {
  const double s = fit.values(j), c = fit.values(j + 1), a = std::hypot(s, c);
  const Eigen::Vector2d radial(s / a, c / a), around(-c / a, s / a);
  const Eigen::Matrix2d covariance = fit.covariance.block<2, 2>(j, j);
  const double bound = std::sqrt(radial.dot(covariance * radial));
  const double turn = std::sqrt(around.dot(covariance * around)) / a * kDegPerRad;
  return {{"amplitude" + suffix, a, unit, bound * grow, bound},
          {"phase" + suffix, std::atan2(c, s) * kDegPerRad, "deg", turn * grow, turn}};
}

// A channel that is blind to the sine or the cosine knows neither amplitude nor phase, only the
// other one's coefficient.
bool SeesBoth(const ChannelFit& fit, Eigen::Index j) {
  return fit.covariance(j, j) > 0.0 && fit.covariance(j + 1, j + 1) > 0.0;
}

// A coefficient of the model. One that these data do not determine is held at 0, and has no number.
ModelParameter Coefficient(const ChannelFit& fit, Eigen::Index j, std::string name,
                           std::string unit, double grow) {
  if (fit.covariance(j, j) > 0.0) return Parameter(fit, j, std::move(name), std::move(unit), grow);
  ModelParameter held;
  held.name = std::move(name);
  held.unit = std::move(unit);
  held.because = "these data do not tell it from the rest of the model, which holds it at 0";
  return held;
}

bool IsWave(const Effect& effect) {
  return effect.terms.size() == 2 && effect.terms[0].name == "a" && effect.terms[1].name == "b";
}

}  // namespace

ModelParameter Parameter(const ChannelFit& fit, Eigen::Index j, std::string name, std::string unit,
                         double grow) {
  const double bound = std::sqrt(fit.covariance(j, j));
  return {std::move(name), fit.values(j), std::move(unit), bound * grow, bound};
}

ModelParameter LargestInData(const ChannelProblem& problem, const ChannelFit& fit,
                             std::size_t index, double grow) {
  // Of those that these data determine; the others are held at 0.
  std::vector<Eigen::Index> columns, parameters;
  const std::vector<Eigen::Index> all = fit.ColumnsOf(index);
  for (std::size_t j = 0; j < all.size(); ++j) {
    const Eigen::Index parameter = fit.member_begin[index] + static_cast<Eigen::Index>(j);
    if (!(fit.covariance(parameter, parameter) > 0.0)) continue;
    columns.push_back(all[j]);
    parameters.push_back(parameter);
  }
  const Eigen::VectorXd coefficients = fit.linear(columns);
  Eigen::VectorXd largest = Eigen::VectorXd::Zero(coefficients.size());
  for (Eigen::Index i = 0; i < problem.rows(); ++i) {
    const double duration_s = problem.intervals()[static_cast<std::size_t>(i)].duration_s;
    const Eigen::VectorXd rates = fit.raw(i, columns).transpose() / duration_s;
    if (std::fabs(rates.dot(coefficients)) > std::fabs(largest.dot(coefficients))) largest = rates;
  }
  const Eigen::MatrixXd covariance = fit.covariance(parameters, parameters);
  const double bound = std::sqrt(largest.dot(covariance * largest));
  return {"largest_in_data", largest.dot(coefficients), "deg/s", bound * grow, bound};
}

std::vector<ModelParameter> EffectParameters(const Candidate& member, const ChannelFit& fit,
                                             std::size_t index, double grow,
                                             const std::vector<std::string>& covariates) {
  std::vector<ModelParameter> out;
  const Eigen::Index first = fit.member_begin[index];
  const Eigen::Index end =
      index + 1 < fit.member_begin.size() ? fit.member_begin[index + 1] : fit.values.size();
  Eigen::Index j = first;
  if (member.effect == nullptr) {
    if (member.empirical()) {
      const Factor factor = *Factor::Make(member.factors[0], 0, covariates);
      return {Parameter(fit, j, "change", "deg/s", grow),
              {"from", member.knots[0], factor.unit(), kMissing, kMissing},
              {"to", member.knots[1], factor.unit(), kMissing, kMissing}};
    }
    for (std::size_t k = 0; k < member.columns.size(); ++k, ++j) {
      const std::string name = member.columns.size() == 1 ? "c" : "c_" + member.factors[2 * k];
      out.push_back(Coefficient(fit, j, name, "deg/s per unit", grow));
    }
    if (j < end) {
      const Factor counted = *Factor::Make(member.origin->of, 0, covariates);
      out.push_back(Parameter(fit, j, member.origin->parameter(), counted.unit(), grow));
    }
    return out;
  }
  const Effect& effect = *member.effect;
  if (IsWave(effect) && SeesBoth(fit, j)) {
    out = AmplitudeAndPhase(fit, j, member.suffix, effect.terms[0].unit, grow);
    j += 2;
  } else {
    for (const EffectTerm& term : effect.terms) {
      if (!IsWave(effect) || fit.covariance(j, j) > 0.0)
        out.push_back(Coefficient(fit, j, term.name + member.suffix, term.unit, grow));
      ++j;
    }
  }
  for (std::size_t k = 0; k < effect.nonlinear.size(); ++k) {
    const NonlinearParameter& parameter = effect.nonlinear[k];
    if (effect.search == Search::kCoefficient) continue;
    if (j < end) {
      out.push_back(Parameter(fit, j++, parameter.name, parameter.unit, grow));
    } else {
      out.push_back(
          {parameter.name, member.context.nonlinear[k], parameter.unit, kMissing, kMissing});
    }
  }
  return out;
}

}  // namespace gyrobench::calibration
