// Reads calibration.json strictly: nothing is guessed, nothing is passed over.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "calibration/artefact/calibration_file.h"
#include "calibration/artefact/json_place.h"
#include "calibration/artefact/vector_json.h"
#include "calibration/effects/effect.h"
#include "calibration/effects/empirical_curve.h"

namespace gyrobench::calibration {
namespace {

using nlohmann::json;

HeldOut ReadHeldOut(const Place& place) {
  place.Keys({"before", "after", "reduction_ci95"});
  return {place["before"].NumberOrNull(), place["after"].NumberOrNull(),
          place["reduction_ci95"].NumbersOrNull<2>()};
}

void CheckCatalogueTerm(const ModelTerm& term, const Place& place) {
  const Effect* effect = FindEffect(CatalogueName(term.id), term.nonlinear.size());
  if (effect == nullptr) {
    return place["id"].Fail(fmt::format(
        "no effect \"{}\" with {} non-linear parameters in the catalogue of this version", term.id,
        term.nonlinear.size()));
  }
  const std::size_t linear =
      effect->search == Search::kCoefficient ? term.coefficients.size() : effect->terms.size();
  if (term.coefficients.size() != linear) {
    place["coefficients"].Expected(fmt::format("{} numbers, for \"{}\"", linear, term.id));
  }
  if ((effect->needs & kNeedsCovariate) != 0 && term.covariate.empty()) {
    place["covariate"].Expected("the name of a column");
  }
}

void CheckTerm(const ModelTerm& term, const Place& place) {
  if (term.origin == EffectOrigin::kCatalogue) return CheckCatalogueTerm(term, place);
  if (term.origin == EffectOrigin::kComposed) {
    if (term.factors.empty()) place["factors"].Expected("at least one factor");
    if (term.offsets.size() != term.factors.size()) {
      place["offsets"].Expected(fmt::format("{} numbers, one a factor", term.factors.size()));
    }
    if (term.coefficients.size() != 1) place["coefficients"].Expected("one number");
    return;
  }
  if (term.factors.size() != 1) place["factors"].Expected("one factor");
  if (term.coefficients.size() != term.knots.size()) {
    place["coefficients"].Expected(fmt::format("{} numbers, one a knot", term.knots.size()));
  }
  try {
    EmpiricalCurve curve(term.knots);
  } catch (const DataError& error) {
    place["knots"].Fail(error.what());
  }
}

std::optional<ChosenOn> ReadChosenOn(const Place& place) {
  if (place.value().is_null()) return std::nullopt;
  return static_cast<ChosenOn>(
      place.Choice({Name(ChosenOn::kTrainingPart), Name(ChosenOn::kAllData)}));
}

ModelTerm ReadTerm(const Place& place) {
  // Files written before it was carried do not say what an effect was chosen on.
  place.Keys(
      {"id", "origin", "owner", "applied", "because", "coefficients", "nonlinear", "table_axis",
       "reference_degC", "covariate", "covariate_mean", "factors", "offsets", "knots"},
      {"chosen_on"});
  ModelTerm term;
  term.id = place["id"].Text();
  term.origin = static_cast<EffectOrigin>(
      place["origin"].Choice({Name(EffectOrigin::kCatalogue), Name(EffectOrigin::kComposed),
                              Name(EffectOrigin::kEmpirical)}));
  term.owner = static_cast<EffectOwner>(place["owner"].Choice(
      {Name(EffectOwner::kGyro), Name(EffectOwner::kReference), Name(EffectOwner::kBench)}));
  term.coefficients = place["coefficients"].Numbers();
  term.nonlinear = place["nonlinear"].Numbers();
  term.table_axis = place["table_axis"].Choice({"outer", "middle", "inner"});
  term.reference_degC = place["reference_degC"].NumberOrNull();
  term.covariate = place["covariate"].Text();
  term.covariate_mean = place["covariate_mean"].Number();
  term.factors = place["factors"].Texts();
  term.offsets = place["offsets"].Numbers();
  term.knots = place["knots"].Numbers();
  if (place.value().contains("chosen_on")) term.chosen_on = ReadChosenOn(place["chosen_on"]);
  CheckTerm(term, place);
  if (place["applied"].Flag() != WhyNotApplied(term).empty()) {
    place["applied"].Fail(fmt::format(
        "{}, but a term of \"{}\" is {}; the owner says whose an effect is",
        place["applied"].Flag(), Name(term.owner),
        WhyNotApplied(term).empty() ? "applied" : "not applied: " + WhyNotApplied(term)));
  }
  place["because"].Text();
  return term;
}

void ReadCovariance(const Place& place, ChannelModel* model) {
  model->parameter_names = place["parameters"].Texts();
  const std::size_t n = model->parameter_names.size();
  const std::vector<Place> rows = place["covariance"].List();
  if (rows.size() != n)
    place["covariance"].Fail(fmt::format("expected {} rows, found {}", n, rows.size()));
  for (const Place& row : rows) {
    const std::vector<Place> values = row.List();
    if (values.size() != n)
      row.Fail(fmt::format("expected {} numbers, found {}", n, values.size()));
    for (const Place& value : values) model->covariance.push_back(value.NumberOrNull());
  }
}

ChannelModel ReadModel(const Place& place) {
  ChannelModel model;
  model.axis = static_cast<SensorAxis>(place["gyro"].Choice({"x", "y", "z"}));
  model.unit = place["unit"].Text();
  model.units_per_deg_s = place["units_per_deg_s"].Positive();
  const std::vector<double> m_row = place["m_row"].Numbers();
  if (m_row.size() != 3) place["m_row"].Expected("3 numbers");
  std::copy(m_row.begin(), m_row.end(), model.m_row.begin());
  model.m_row_std_error = place["m_row_std_error"].NumbersOrNull<3>();
  const Place bias = place["bias"];
  bias.Keys({"reference_degC", "coefficients_deg_s"});
  model.reference_degC = bias["reference_degC"].NumberOrNull();
  model.bias_deg_s = bias["coefficients_deg_s"].Numbers();
  if (model.bias_deg_s.size() > 1 && std::isnan(model.reference_degC)) {
    bias["reference_degC"].Expected("a temperature, for a bias that depends on it");
  }
  for (const Place& term : place["terms"].List()) model.terms.push_back(ReadTerm(term));
  ReadCovariance(place, &model);
  const Place validity = place["validity"];
  validity.Keys({"min_temperature_degC", "max_temperature_degC", "max_rate_deg_s"});
  model.min_temperature_degC = validity["min_temperature_degC"].NumberOrNull();
  model.max_temperature_degC = validity["max_temperature_degC"].NumberOrNull();
  model.max_rate_deg_s = validity["max_rate_deg_s"].NumberOrNull();
  return model;
}

TraceNoise ReadNoise(const Place& place) {
  place.Keys({"angle_random_walk_deg_sqrt_s", "bias_random_walk_deg_s_sqrt_s"});
  return {place["angle_random_walk_deg_sqrt_s"].NumberOrNull(),
          place["bias_random_walk_deg_s_sqrt_s"].NumberOrNull(), kMissing};
}

ChannelCalibration ReadChannel(const Place& place) {
  // Files written before the noise was part of the format stay readable.
  place.Keys(
      {"gyro", "unit", "units_per_deg_s", "m_row", "m_row_std_error", "bias", "terms", "parameters",
       "covariance", "validity", "verdict", "heldout_whitened_rms", "heldout_angle_rms_deg"},
      {"noise"});
  ChannelCalibration channel;
  channel.model = ReadModel(place);
  channel.verdict = static_cast<Verdict>(
      place["verdict"].Choice({Name(Verdict::kNone), Name(Verdict::kExplained),
                               Name(Verdict::kPartlyExplained), Name(Verdict::kUnexplained)}));
  channel.heldout_whitened_rms = ReadHeldOut(place["heldout_whitened_rms"]);
  channel.heldout_angle_rms_deg = ReadHeldOut(place["heldout_angle_rms_deg"]);
  if (place.value().contains("noise")) channel.noise = ReadNoise(place["noise"]);
  return channel;
}

CalibrationInput ReadInput(const Place& place) {
  place.Keys({"file", "sha256", "samples", "duration_s"});
  CalibrationInput input;
  input.file = place["file"].Text();
  input.sha256 = place["sha256"].Text();
  input.samples = place["samples"].Count();
  input.duration_s = place["duration_s"].NumberOrNull();
  return input;
}

// Before all else: a file of another kind must not be called a calibration with missing keys.
void CheckFormat(const json& value, const std::string& file) {
  const bool told = value.is_object() && value.contains("format") && value["format"].is_string();
  const std::string format = told ? value["format"].get<std::string>() : "";
  if (format == kCalibrationFormat) return;
  const std::string made_by =
      "a calibration is made with: gyrobench trace FILE... --calibration " + file;
  if (format.starts_with("gyrobench.calibration/")) {
    throw DataError(
        fmt::format("{}: format: \"{}\" is of another version of gyrobench; this one "
                    "reads \"{}\"; {}",
                    file, format, kCalibrationFormat, made_by));
  }
  throw DataError(fmt::format("{}: no calibration: expected \"format\": \"{}\", found {}; {}", file,
                              kCalibrationFormat, told ? '"' + format + '"' : "no such key",
                              made_by));
}

}  // namespace

Calibration CalibrationFromJson(const json& value, const std::string& file) {
  CheckFormat(value, file);
  const Place top(value, file);
  // Files written before the axes were joined, or before the zero was carried, stay readable.
  top.Keys(
      {"format", "model", "sensor", "created", "version", "inputs", "configuration", "channels"},
      {"vector", "gyro_lsb_zero"});
  Calibration calibration;
  calibration.sensor = top["sensor"].Text();
  calibration.created = top["created"].Text();
  calibration.version = top["version"].Text();
  for (const Place& input : top["inputs"].List()) calibration.inputs.push_back(ReadInput(input));
  const Place configuration = top["configuration"];
  if (!configuration.value().is_object()) configuration.Expected("an object {...}");
  for (const auto& item : configuration.value().items()) {
    calibration.configuration[item.key()] = configuration[item.key().c_str()].Text();
  }
  std::array<bool, 3> seen = {};
  for (const Place& channel : top["channels"].List()) {
    calibration.channels.push_back(ReadChannel(channel));
    const auto axis = static_cast<std::size_t>(calibration.channels.back().model.axis);
    if (std::exchange(seen[axis], true)) {
      channel["gyro"].Fail(fmt::format("gyro {} is there twice", "xyz"[axis]));
    }
  }
  if (calibration.channels.empty()) top["channels"].Expected("at least one channel");
  if (value.contains("gyro_lsb_zero") && !value["gyro_lsb_zero"].is_null())
    calibration.gyro_lsb_zero = top["gyro_lsb_zero"].Number();
  if (value.contains("vector")) calibration.vector = VectorFromJson(top["vector"]);
  return calibration;
}

}  // namespace gyrobench::calibration
