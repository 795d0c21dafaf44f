#include "calibration/hold/hold_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <vector>

#include "base/geometry.h"
#include "calibration/hold/estimate_noise.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Index;

constexpr int kSteps = 12;
// Of a standard error, or of a parameter: a matrix element, a g, a rad/s/g.
constexpr double kConverged = 1e-3, kConvergedBy = 1e-7;
constexpr double kFalseMisfit = 1e-3;
constexpr double kMostLeftOut = 0.2;

// The largest step of a parameter in its standard errors.
double StepSize(const ArrowSystem::Solution& step) {
  return step.parameters
      .cwiseQuotient(step.covariance.diagonal().head(step.parameters.size()).cwiseSqrt())
      .cwiseAbs()
      .maxCoeff();
}

void Drop(const std::vector<Misfit>& left_out, LinearModel* model) {
  for (HoldFactor& factor : model->factors)
    for (const Misfit& misfit : left_out)
      if (factor.kind == misfit.kind && factor.node == static_cast<Index>(misfit.index))
        factor.used = false;
}

class Fitter {
 public:
  Fitter(const HeldChain& chain, double latitude_rad, HoldFit* fit)
      : chain_(chain), latitude_rad_(latitude_rad), fit_(*fit) {}

  // Newton's steps until they are small; false where something is not determined.
  bool Converge() {
    fit_.converged = false;
    for (int step = 0; step < kSteps; ++step) {
      LinearizeHere();
      fit_.solution = SolveModel(fit_.model, fit_.noise);
      if (!fit_.solution.positive || !fit_.solution.parameters.allFinite()) return false;
      fit_.converged = StepSize(fit_.solution) < kConverged ||
                       fit_.solution.parameters.cwiseAbs().maxCoeff() < kConvergedBy;
      if (fit_.converged) return true;
      Move(fit_.solution, fit_.extent, &fit_.state);
      if (!fit_.state.m.allFinite() || fit_.state.m.norm() > 100.0 ||
          fit_.state.accel.shear.cwiseAbs().maxCoeff() > 0.5)
        return false;
    }
    LinearizeHere();
    fit_.solution = SolveModel(fit_.model, fit_.noise);
    fit_.converged = fit_.solution.positive && StepSize(fit_.solution) < 0.1;
    return fit_.converged;
  }

  void LinearizeHere() {
    fit_.model = Linearize(chain_, fit_.state, fit_.extent, latitude_rad_);
    Drop(fit_.left_out, &fit_.model);
  }

  void FindNoise() { fit_.noise = EstimateNoise(fit_.model, fit_.noise); }

  // Deletes each turn and each mean in turn, and finds the one that is missed least.
  Misfit Worst() {
    std::vector<double> turns, means;
    Misfit worst;
    double least_p = 1.0;
    const double all = fit_.solution.residual_square;
    for (HoldFactor& factor : fit_.model.factors) {
      const bool turn = factor.kind == FactorKind::kTurn;
      if (!factor.used || (!turn && factor.kind != FactorKind::kAccel)) continue;
      factor.used = false;
      const ArrowSystem::Solution without = SolveModel(fit_.model, fit_.noise);
      factor.used = true;
      if (!without.positive) continue;  // a rest between two turns that are left out
      const double gain = std::max(0.0, all - without.residual_square);
      (turn ? turns : means).push_back(gain / static_cast<double>(factor.rows));
      const boost::math::chi_squared law(static_cast<double>(factor.rows));
      const double p = boost::math::cdf(boost::math::complement(law, gain));
      if (p >= least_p) continue;
      least_p = p;
      worst = {factor.kind, static_cast<std::size_t>(factor.node), gain,
               static_cast<int>(factor.rows)};
    }
    fit_.turn_whitened_rms = RootMean(turns);
    fit_.accel_whitened_rms = RootMean(means);
    const double tried = static_cast<double>(turns.size() + means.size());
    if (!(least_p * tried < kFalseMisfit)) worst.chi_square = 0.0;
    return worst;
  }

 private:
  static double RootMean(const std::vector<double>& squares) {
    if (squares.empty()) return kMissing;
    double sum = 0.0;
    for (const double square : squares) sum += square;
    return std::sqrt(sum / static_cast<double>(squares.size()));
  }

  const HeldChain& chain_;
  double latitude_rad_;
  HoldFit& fit_;
};

}  // namespace

HoldFit FitHeldPoses(const HeldChain& chain, const HoldState& start, const HoldNoise& noise,
                     double latitude_rad) {
  HoldFit fit;
  fit.state = start;
  fit.noise = noise;
  Fitter fitter(chain, latitude_rad, &fit);
  // Without g-sensitivity first: far from the truth it could take what the matrix has to.
  if (!fitter.Converge()) return fit;
  fit.extent.g_sensitivity = true;
  const auto most =
      static_cast<std::size_t>(kMostLeftOut * static_cast<double>(chain.rests.size()));
  for (;;) {
    if (!fitter.Converge()) return fit;
    fitter.FindNoise();
    if (!fitter.Converge()) return fit;
    fitter.FindNoise();
    if (!fitter.Converge()) return fit;
    const Misfit worst = fitter.Worst();
    if (worst.chi_square == 0.0 || fit.left_out.size() >= most) return fit;
    fit.left_out.push_back(worst);
  }
}

HoldFit Refit(const HeldChain& chain, const HoldFit& fit, const ModelExtent& extent,
              double latitude_rad) {
  HoldFit out = fit;
  out.extent = extent;
  if (!extent.g_sensitivity) out.state.g_sensitivity.setZero();
  Fitter fitter(chain, latitude_rad, &out);
  fitter.Converge();
  return out;
}

WaldTest TestColumns(const ArrowSystem::Solution& solution, const Eigen::VectorXd& at,
                     const std::vector<Index>& columns, double degrees_of_noise) {
  WaldTest out;
  const Eigen::MatrixXd covariance = solution.covariance(columns, columns);
  out.values = at;
  out.std_errors = covariance.diagonal().cwiseSqrt();
  out.chi_square = at.dot(covariance.ldlt().solve(at));
  const auto n = static_cast<double>(columns.size());
  if (!std::isfinite(out.chi_square) || !(degrees_of_noise >= 1.0)) return out;
  const boost::math::fisher_f law(n, degrees_of_noise);
  out.p_value = boost::math::cdf(boost::math::complement(law, out.chi_square / n));
  return out;
}

double TurnFreedom(const HoldFit& fit) {
  double freedom = -9.0;
  for (const HoldFactor& factor : fit.model.factors)
    if (factor.used && factor.kind == FactorKind::kTurn) freedom += 2.0;
  return std::max(1.0, freedom);
}

}  // namespace gyrobench::calibration
