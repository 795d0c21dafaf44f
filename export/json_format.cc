// Format `json`: what `gyrobench apply` uses of a calibration, ready to be used by a program.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "base/json_text.h"
#include "calibration/effects/effect.h"
#include "export/formats.h"
#include "export/text.h"

namespace gyrobench::exporting {
namespace {

using Json = nlohmann::ordered_json;

std::string EquationOf(const calibration::ModelTerm& term) {
  switch (term.origin) {
    case calibration::EffectOrigin::kCatalogue: {
      const calibration::Effect* effect =
          calibration::FindEffect(calibration::CatalogueName(term.id), term.nonlinear.size());
      return effect == nullptr ? "" : effect->equation;
    }
    case calibration::EffectOrigin::kComposed:
      return "coefficients[0] times the product of (factors[i] - offsets[i])";
    case calibration::EffectOrigin::kEmpirical:
      break;
  }
  return "a curve in factors[0] through (knots[i], coefficients[i]), straight between, constant "
         "outside";
}

Json EffectJson(const calibration::ChannelModel& model, const calibration::ModelTerm& term) {
  Json out = {{"id", term.id},
              {"origin", calibration::Name(term.origin)},
              {"equation", EquationOf(term)},
              {"coefficients", term.coefficients}};
  if (const auto names = NotDetermined(model, term); !names.empty()) out["not_determined"] = names;
  if (!term.nonlinear.empty()) out["nonlinear"] = term.nonlinear;
  if (!term.factors.empty()) out["factors"] = term.factors;
  if (!term.offsets.empty()) out["offsets"] = term.offsets;
  if (!term.knots.empty()) out["knots"] = term.knots;
  if (!term.covariate.empty()) {
    out["column"] = term.covariate;
    out["column_mean"] = term.covariate_mean;
  }
  if (term.origin == calibration::EffectOrigin::kCatalogue)
    out["reference_degC"] = Number(term.reference_degC);
  return out;
}

Json AxisJson(const LinearModel& model, std::size_t c) {
  const calibration::ChannelModel* axis = model.axes[c];
  Json out = {{"axis", std::string(1, kAxisNames[c])},
              {"calibrated", axis != nullptr},
              {"units_per_deg_s", model.units_per_deg_s[c]}};
  if (axis == nullptr) return out;
  out["bias"] = {{"reference_degC", Number(axis->reference_degC)},
                 {"coefficients_deg_s", axis->bias_deg_s}};
  out["effects"] = Json::array();
  for (const calibration::ModelTerm& term : axis->terms)
    if (calibration::WhyNotApplied(term).empty()) out["effects"].push_back(EffectJson(*axis, term));
  out["valid_for"] = {{"min_temperature_degC", Number(axis->min_temperature_degC)},
                      {"max_temperature_degC", Number(axis->max_temperature_degC)},
                      {"max_rate_deg_s", Number(axis->max_rate_deg_s)}};
  return out;
}

Json FormulaJson() {
  constexpr const char* kHeldText =
      "T: held within valid_for, in bias and effects; w: held within +- max_rate_deg_s in effects "
      "that are no straight line in it";
  constexpr const char* kGravityText =
      "gravity in effects: specific force at rest in g, of length 1, +1 on the axis that points up";
  return {"xi_c = count of the converter - lsb_zero, where that is known",
          "y_c = xi_c / units_per_deg_s_c - sum_k bias_k (T - reference_degC)^k - sum of effects",
          "w_c = sum_d matrix[c][d] y_d   [deg/s, about the sensor's axes x, y, z]",
          "effects that depend on w: repeat both lines, from the w before, until w stays",
          kHeldText,
          kGravityText};
}

Json ExampleJson(const calibration::Calibration& calibration) {
  const Example example = WorkedExample(calibration);
  return {{"xi", example.xi},
          {"temperature_degC", example.temperature_degC},
          {"temperature_rate_degC_s", 0.0},
          {"since_power_on_s", 0.0},
          {"gravity_g", example.gravity_g},
          {"rate_deg_s", example.rate_deg_s}};
}

}  // namespace

Exported WriteJson(const calibration::Calibration& calibration, const Origin& origin) {
  const LinearModel model = MakeLinearModel(calibration);
  Exported out;
  out.warnings = SetToZero(calibration);
  out.notes = WhatNoCorrectionHolds(calibration, model);
  Json axes = Json::array();
  for (std::size_t c = 0; c < 3; ++c) axes.push_back(AxisJson(model, c));
  Json noise = Json::array();
  for (const calibration::ChannelCalibration& channel : calibration.channels) {
    noise.push_back(
        {{"axis", std::string(1, kAxisNames[static_cast<std::size_t>(channel.model.axis)])},
         {"angle_random_walk_deg_sqrt_s", Number(channel.noise.angle_random_walk_deg_sqrt_s)},
         {"bias_random_walk_deg_s_sqrt_s", Number(channel.noise.bias_random_walk_deg_s_sqrt_s)}});
  }
  const Json file = {
      {"format", "gyrobench.correction/1"},
      {"formula", FormulaJson()},
      {"written_by", "gyrobench " + origin.version},
      {"calibration", {{"file", origin.file}, {"sha256", origin.sha256}}},
      {"sensor", calibration.sensor},
      {"calibrated", calibration.created},
      {"unit", model.unit},
      {"lsb_zero", calibration.gyro_lsb_zero ? Json(*calibration.gyro_lsb_zero) : Json(nullptr)},
      {"matrix", model.inverse},
      {"axes", axes},
      {"noise", noise},
      {"example", ExampleJson(calibration)},
      {"left_out", out.notes}};
  out.text = JsonText(file, 2) + "\n";
  return out;
}

}  // namespace gyrobench::exporting
