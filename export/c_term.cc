#include "export/c_term.h"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "calibration/artefact/calibration_file.h"
#include "calibration/artefact/corrector_channel.h"
#include "calibration/artefact/model_terms.h"
#include "calibration/effects/effect.h"
#include "export/text.h"

namespace gyrobench::exporting {
namespace {

using calibration::ModelTerm;

constexpr double kSmallestFloat = 1e-37;
// Inputs of the function.
constexpr const char *kGravity = "g[", *kTemperatureRate = "in->temperature_rate_degC_s",
                     *kSincePowerOn = "in->since_power_on_s";
constexpr std::array<const char*, 3> kCoefficients = {"c0", "c1", "c2"};

// The names of the variables, for one channel and one dependence on the rate.
struct Variables {
  std::size_t channel = 2;
  bool held = false;

  std::string RateAbout(std::size_t axis) const {
    return fmt::format("{}[{}]", held ? "h" : "w", axis);
  }
  std::string Rate() const { return RateAbout(channel); }
  std::string Temperature() const { return fmt::format("t[{}]", channel); }
};

std::string Gravity(std::size_t axis) { return fmt::format("g[{}]", axis); }
std::string Size(const std::string& value) { return "GYROBENCH_SIZE(" + value + ")"; }

std::string First(const ModelTerm& term) { return CNumber(term.coefficients[0]); }

// What an expression asks of the function's input.
CNeeds NeedsOf(const std::string& text) {
  const auto has = [&](const char* input) { return text.find(input) != std::string::npos; };
  return {has(kGravity), has(kTemperatureRate), has(kSincePowerOn)};
}

// Effect::c_expression with the numbers and names put in.
std::string Expression(const calibration::Effect& effect, const ModelTerm& term,
                       const Variables& names) {
  fmt::dynamic_format_arg_store<fmt::format_context> values;
  for (std::size_t i = 0; i < term.coefficients.size(); ++i)
    values.push_back(fmt::arg(kCoefficients.at(i), CNumber(term.coefficients[i])));
  if (!term.nonlinear.empty())
    values.push_back(fmt::arg("minus_1_over_n0", CNumber(-1.0 / term.nonlinear[0])));
  const std::string rate = names.Rate(), temperature = names.Temperature();
  values.push_back(fmt::arg("w", rate));
  values.push_back(fmt::arg("t", temperature));
  // Of measurements without a temperature nobody knows it, and what does not ask for it goes without.
  if (effect.c_expression.find("{t0}") != std::string::npos)
    values.push_back(fmt::arg("t0", CNumber(term.reference_degC)));
  return fmt::vformat(effect.c_expression, values);
}

// A factor of a composed effect or a curve; nullopt for a column of the table.
std::optional<std::string> FactorText(const std::string& name, const Variables& names) {
  if (name == "w") return names.Rate();
  if (name == "abs_w") return Size(names.Rate());
  if (name == "T") return names.Temperature();
  if (name == "dT_dt") return kTemperatureRate;
  const bool has_axis = name.size() == 3 && name[1] == '_' && name[2] >= 'x' && name[2] <= 'z';
  if (!has_axis || (name[0] != 'w' && name[0] != 'g')) return std::nullopt;
  const auto axis = static_cast<std::size_t>(name[2] - 'x');
  if (name[0] == 'w') return names.RateAbout(axis);
  return Gravity(axis);
}

std::string ProductText(const ModelTerm& term, const std::vector<std::string>& factors) {
  std::string text = First(term);
  for (std::size_t i = 0; i < factors.size(); ++i)
    text += fmt::format(" * ({} - {})", factors[i], CNumber(term.offsets[i]));
  return text;
}

// Straight between the knots, constant outside: the first value and the rises over the pieces, each
// held within its own.
std::string CurveText(const ModelTerm& term, const std::string& x) {
  const std::vector<double>&at = term.knots, &value = term.coefficients;
  // What is not a number stays so, one knot or many.
  if (at.size() == 1) return fmt::format("({} + {} * {})", CNumber(value[0]), CNumber(0.0), x);
  std::string text = CNumber(value[0]);
  for (std::size_t i = 1; i < at.size(); ++i) {
    text += fmt::format(" + {0} * (GYROBENCH_HELD({1}, {2}, {3}) - {2})",
                        CNumber((value[i] - value[i - 1]) / (at[i] - at[i - 1])), x,
                        CNumber(at[i - 1]), CNumber(at[i]));
  }
  return "(" + text + ")";
}

std::string NoInput(const std::string& name) {
  return "it depends on " + name + ", which is no input of the function";
}

std::optional<CTerm> CatalogueTerm(const ModelTerm& term, const Variables& names,
                                   std::string* why_not) {
  const calibration::Effect* effect =
      calibration::FindEffect(calibration::CatalogueName(term.id), term.nonlinear.size());
  if (effect == nullptr || effect->c_expression.empty()) {
    *why_not = term.covariate.empty()
                   ? "it needs a memory or the vibration, and the function has neither"
                   : NoInput("the column " + term.covariate);
    return std::nullopt;
  }
  return CTerm{Dependence::kNoRate, Expression(*effect, term, names), {}};
}

std::optional<CTerm> FreeTerm(const ModelTerm& term, const Variables& names, std::string* why_not) {
  CTerm out;
  std::vector<std::string> factors;
  for (const std::string& name : term.factors) {
    std::optional<std::string> text = FactorText(name, names);
    if (!text) {
      *why_not = NoInput("the column " + name);
      return std::nullopt;
    }
    factors.push_back(*std::move(text));
  }
  out.text = term.origin == calibration::EffectOrigin::kComposed ? ProductText(term, factors)
                                                                 : CurveText(term, factors[0]);
  return out;
}

// As the corrector judges it, so that both hold the same rates.
Dependence DependenceOf(const ModelTerm& term, SensorAxis axis) {
  MeasurementInfo info;
  info.accel_present = {true, true, true};
  info.temperature_present = true;
  std::string why_not;
  std::unique_ptr<calibration::TermFunction> function =
      calibration::MakeTermFunction(term, axis, info, &why_not);
  calibration::CorrectorChannel channel;
  if (function) channel.AddTerm(std::move(function), 0);
  if (!channel.bent.empty()) return Dependence::kBentInRate;
  return channel.straight.empty() ? Dependence::kNoRate : Dependence::kStraightInRate;
}

}  // namespace

std::string CLiteral(double value) {
  RequireFloat(value);
  if (std::fabs(value) < kSmallestFloat) return "0.0";
  std::string text = fmt::format("{}", value);
  // An integer would take no suffix.
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string CNumber(double value) { return "GYROBENCH_C(" + CLiteral(value) + ")"; }

std::optional<CTerm> MakeCTerm(const ModelTerm& term, SensorAxis axis, std::string* why_not) {
  const Dependence dependence = DependenceOf(term, axis);
  const Variables names = {static_cast<std::size_t>(axis), dependence == Dependence::kBentInRate};
  std::optional<CTerm> out = term.origin == calibration::EffectOrigin::kCatalogue
                                 ? CatalogueTerm(term, names, why_not)
                                 : FreeTerm(term, names, why_not);
  if (out) {
    out->dependence = dependence;
    out->needs = NeedsOf(out->text);
  }
  return out;
}

}  // namespace gyrobench::exporting
