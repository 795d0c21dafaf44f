#include "calibration/artefact/calibration_file.h"

#include <array>
#include <nlohmann/json.hpp>

#include "base/json_number.h"
#include "calibration/artefact/vector_json.h"
#include "calibration/effects/effect.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
constexpr std::array<const char*, 3> kTableAxes = {"outer", "middle", "inner"};

json ToJson(const HeldOut& held_out) {
  return {{"before", Number(held_out.before)},
          {"after", Number(held_out.after)},
          {"reduction_ci95", Numbers(held_out.reduction_ci95)}};
}

json ToJson(const ModelTerm& term) {
  const std::string because = WhyNotApplied(term);
  return {{"id", term.id},
          {"origin", Name(term.origin)},
          {"owner", Name(term.owner)},
          {"applied", because.empty()},
          {"because", because},
          {"coefficients", Numbers(term.coefficients)},
          {"nonlinear", Numbers(term.nonlinear)},
          {"table_axis", kTableAxes.at(term.table_axis)},
          {"reference_degC", Number(term.reference_degC)},
          {"covariate", term.covariate},
          {"covariate_mean", Number(term.covariate_mean)},
          {"factors", term.factors},
          {"offsets", Numbers(term.offsets)},
          {"knots", Numbers(term.knots)},
          {"chosen_on", term.chosen_on ? json(Name(*term.chosen_on)) : json(nullptr)}};
}

json ToJson(const ChannelCalibration& channel) {
  const ChannelModel& model = channel.model;
  json terms = json::array();
  for (const ModelTerm& term : model.terms) terms.push_back(ToJson(term));
  return {
      {"gyro", kAxes.at(static_cast<std::size_t>(model.axis))},
      {"unit", model.unit},
      {"units_per_deg_s", Number(model.units_per_deg_s)},
      {"m_row", Numbers(model.m_row)},
      {"m_row_std_error", Numbers(model.m_row_std_error)},
      {"bias",
       {{"reference_degC", Number(model.reference_degC)},
        {"coefficients_deg_s", Numbers(model.bias_deg_s)}}},
      {"terms", terms},
      {"parameters", model.parameter_names},
      {"covariance", SquareRows(model.covariance, model.parameter_names.size())},
      {"validity",
       {{"min_temperature_degC", Number(model.min_temperature_degC)},
        {"max_temperature_degC", Number(model.max_temperature_degC)},
        {"max_rate_deg_s", Number(model.max_rate_deg_s)}}},
      {"verdict", Name(channel.verdict)},
      {"heldout_whitened_rms", ToJson(channel.heldout_whitened_rms)},
      {"heldout_angle_rms_deg", ToJson(channel.heldout_angle_rms_deg)},
      {"noise",
       {{"angle_random_walk_deg_sqrt_s", Number(channel.noise.angle_random_walk_deg_sqrt_s)},
        {"bias_random_walk_deg_s_sqrt_s", Number(channel.noise.bias_random_walk_deg_s_sqrt_s)}}}};
}

}  // namespace

std::string WhyNotApplied(const ModelTerm& term) {
  if (term.owner == EffectOwner::kReference) return "an error of the reference, not of the gyro";
  if (term.owner == EffectOwner::kBench) return "an effect of the bench, not of the gyro";
  if (term.origin != EffectOrigin::kCatalogue) return "";
  const Effect* effect = FindEffect(CatalogueName(term.id), term.nonlinear.size());
  if (effect == nullptr) return "it is not in the catalogue of this version";
  if (effect->true_motion) return "Earth's rotation is true motion, not an error";
  if (effect->of_one_time()) return "its time and phase are of the run that it was found in";
  if (effect->domain == EffectDomain::kAngle) return "a lag cannot be undone sample by sample";
  return "";
}

json ToJson(const Calibration& calibration) {
  json inputs = json::array(), channels = json::array();
  for (const CalibrationInput& input : calibration.inputs) {
    inputs.push_back({{"file", input.file},
                      {"sha256", input.sha256},
                      {"samples", input.samples},
                      {"duration_s", Number(input.duration_s)}});
  }
  for (const ChannelCalibration& channel : calibration.channels) {
    channels.push_back(ToJson(channel));
  }
  json file = {
      {"format", kCalibrationFormat},
      {"model",
       "xi / s0 = sum_j M_j w_j + sum_k b_k (T - T0)^k + sum of terms [deg/s]; gyrobench's "
       "docs/calibration.md"},
      {"sensor", calibration.sensor},
      {"created", calibration.created},
      {"version", calibration.version},
      {"inputs", inputs},
      {"configuration", calibration.configuration},
      {"gyro_lsb_zero", Number(calibration.gyro_lsb_zero)},
      {"channels", channels}};
  if (calibration.vector) file["vector"] = ToJson(*calibration.vector);
  return file;
}

}  // namespace gyrobench::calibration
