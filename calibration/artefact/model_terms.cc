#include "calibration/artefact/model_terms.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "calibration/artefact/calibration_file.h"
#include "calibration/effects/effect.h"
#include "calibration/effects/empirical_curve.h"
#include "calibration/effects/factor.h"

namespace gyrobench::calibration {
namespace {

// sum_j coefficients[j] basis_j
class CatalogueTerm final : public TermFunction {
 public:
  CatalogueTerm(const Effect& effect, const BasisContext& context, std::vector<double> coefficients)
      : basis_(effect.basis(context)),
        coefficients_(std::move(coefficients)),
        values_(std::max(coefficients_.size(), effect.terms.size())),
        depends_on_rate_((effect.needs & kNeedsRate) != 0) {}
  double At(const SensorState& point) override {
    basis_->At(point, values_.data());
    return std::inner_product(coefficients_.begin(), coefficients_.end(), values_.begin(), 0.0);
  }
  bool depends_on_rate() const override { return depends_on_rate_; }

 private:
  std::unique_ptr<Basis> basis_;
  std::vector<double> coefficients_, values_;
  bool depends_on_rate_;
};

bool IsRate(const std::string& factor) { return factor == "abs_w" || factor.starts_with("w"); }

// coefficient * product of (factor - its offset)
class ComposedTerm final : public TermFunction {
 public:
  ComposedTerm(std::vector<Factor> factors, std::vector<double> offsets, double coefficient)
      : factors_(std::move(factors)), offsets_(std::move(offsets)), coefficient_(coefficient) {}
  double At(const SensorState& point) override {
    double product = coefficient_;
    for (std::size_t i = 0; i < factors_.size(); ++i)
      product *= factors_[i].At(point) - offsets_[i];
    return product;
  }
  bool depends_on_rate() const override {
    return std::any_of(factors_.begin(), factors_.end(),
                       [](const Factor& factor) { return IsRate(factor.name()); });
  }

 private:
  std::vector<Factor> factors_;
  std::vector<double> offsets_;
  double coefficient_;
};

class EmpiricalTerm final : public TermFunction {
 public:
  EmpiricalTerm(Factor factor, EmpiricalCurve curve, std::vector<double> values)
      : factor_(std::move(factor)), curve_(std::move(curve)), values_(std::move(values)) {}
  double At(const SensorState& point) override { return curve_.Value(factor_.At(point), values_); }
  bool depends_on_rate() const override { return IsRate(factor_.name()); }

 private:
  Factor factor_;
  EmpiricalCurve curve_;
  std::vector<double> values_;
};

std::string NoColumn(const std::string& name) {
  return fmt::format("it needs the column {}, which is not there", name);
}

// What must be measured for gravity, temperature and vibration to be known.
std::string Missing(unsigned needs, const MeasurementInfo& info) {
  const bool accel = info.accel_present[0] && info.accel_present[1] && info.accel_present[2];
  if ((needs & kNeedsGravity) != 0 && !accel)
    return "it needs gravity, and there is no accelerometer of three axes";
  if ((needs & kNeedsVibration) != 0 && !accel)
    return "it needs the vibration, and there is no accelerometer of three axes";
  if ((needs & kNeedsTemperature) != 0 && !info.temperature_present) return NoColumn("temp_degC");
  return "";
}

unsigned NeedsOf(const std::string& factor) {
  if (factor == "T" || factor == "dT_dt") return kNeedsTemperature;
  if (factor == "g_x" || factor == "g_y" || factor == "g_z") return kNeedsGravity;
  return kNeedsNothing;
}

std::unique_ptr<TermFunction> MakeCatalogueTerm(const ModelTerm& term, std::size_t channel,
                                                const MeasurementInfo& info, std::string* why_not) {
  const Effect* effect = FindEffect(CatalogueName(term.id), term.nonlinear.size());
  if (effect == nullptr) {
    *why_not = "it is not in the catalogue of this version";
    return nullptr;
  }
  *why_not = Missing(effect->needs, info);
  if (!why_not->empty()) return nullptr;
  BasisContext context;
  context.channel = channel;
  context.table_axis = term.table_axis;
  context.gear_ratio = info.gear_ratio.value_or(context.gear_ratio);
  context.reference_degC = term.reference_degC;
  context.covariate_mean = term.covariate_mean;
  context.nonlinear = term.nonlinear;
  if ((effect->needs & kNeedsCovariate) != 0) {
    const auto column = std::find(info.covariates.begin(), info.covariates.end(), term.covariate);
    if (column == info.covariates.end()) {
      *why_not = NoColumn(term.covariate);
      return nullptr;
    }
    context.covariate = static_cast<std::size_t>(column - info.covariates.begin());
  }
  return std::make_unique<CatalogueTerm>(*effect, context, term.coefficients);
}

}  // namespace

std::unique_ptr<TermFunction> MakeTermFunction(const ModelTerm& term, SensorAxis axis,
                                               const MeasurementInfo& info, std::string* why_not) {
  const auto channel = static_cast<std::size_t>(axis);
  if (term.origin == EffectOrigin::kCatalogue)
    return MakeCatalogueTerm(term, channel, info, why_not);
  std::vector<Factor> factors;
  for (const std::string& name : term.factors) {
    *why_not = Missing(NeedsOf(name), info);
    if (!why_not->empty()) return nullptr;
    std::optional<Factor> factor = Factor::Make(name, channel, info.covariates);
    if (!factor) {
      *why_not = NoColumn(name);
      return nullptr;
    }
    factors.push_back(*std::move(factor));
  }
  if (term.origin == EffectOrigin::kComposed)
    return std::make_unique<ComposedTerm>(std::move(factors), term.offsets, term.coefficients[0]);
  return std::make_unique<EmpiricalTerm>(std::move(factors[0]), EmpiricalCurve(term.knots),
                                         term.coefficients);
}

}  // namespace gyrobench::calibration
