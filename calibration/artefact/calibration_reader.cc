// What has to hold between the fields of calibration.json, and reading it.
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "calibration/artefact/calibration_fields.h"
#include "calibration/effects/effect.h"
#include "calibration/effects/empirical_curve.h"

namespace gyrobench::calibration {
namespace {

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

void CheckForm(const ModelTerm& term, const Place& place) {
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

// Before all else: a file of another kind must not be called a calibration with missing keys.
void CheckFormat(const nlohmann::json& value, const std::string& file) {
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

void CheckTerm(const ModelTerm& term, const Place& place) {
  CheckForm(term, place);
  if (place["applied"].Flag() != WhyNotApplied(term).empty()) {
    place["applied"].Fail(fmt::format(
        "{}, but a term of \"{}\" is {}; the owner says whose an effect is",
        place["applied"].Flag(), Name(term.owner),
        WhyNotApplied(term).empty() ? "applied" : "not applied: " + WhyNotApplied(term)));
  }
  place["because"].Text();
}

void CheckBias(const ChannelModel& model, const Place& bias) {
  if (model.bias_deg_s.size() > 1 && std::isnan(model.reference_degC))
    bias["reference_degC"].Expected("a temperature, for a bias that depends on it");
}

void CheckChannels(const Calibration& calibration, const Place& place) {
  const std::vector<Place> channels = place["channels"].List();
  if (channels.empty()) place["channels"].Expected("at least one channel");
  std::array<bool, 3> seen = {};
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto axis = static_cast<std::size_t>(calibration.channels[i].model.axis);
    if (std::exchange(seen[axis], true))
      channels[i]["gyro"].Fail(fmt::format("gyro {} is there twice", kSensorAxisNames[axis]));
  }
}

Calibration CalibrationFromJson(const nlohmann::json& value, const std::string& file) {
  CheckFormat(value, file);
  return ReadFields<Calibration>(Place(value, file));
}

}  // namespace gyrobench::calibration
