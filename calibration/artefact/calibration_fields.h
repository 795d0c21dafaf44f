// The lists of fields of calibration.json, and what has to hold between them: docs/calibration.md.
#pragma once

#include "base/measurement_fields.h"
#include "calibration/artefact/calibration_file.h"
#include "calibration/artefact/trace_fields.h"
#include "calibration/artefact/vector_fields.h"

namespace gyrobench::calibration {

// Each throws DataError at its place where the fields, each as it should be, do not fit together.
void CheckTerm(const ModelTerm& term, const Place& place);
void CheckBias(const ChannelModel& model, const Place& bias);
void CheckChannels(const Calibration& calibration, const Place& place);

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, CalibrationInput>& input) {
  field("file", input.file);
  field("sha256", input.sha256);
  field("samples", input.samples);
  field("duration_s", input.duration_s);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ModelTerm>& term) {
  field("id", term.id);
  field("origin", term.origin, NamesUpTo(EffectOrigin::kEmpirical));
  field("owner", term.owner, NamesUpTo(EffectOwner::kBench));
  field.Derived("applied", [&] { return WhyNotApplied(term).empty(); });
  field.Derived("because", [&] { return WhyNotApplied(term); });
  field("coefficients", term.coefficients);
  field("nonlinear", term.nonlinear);
  field("table_axis", term.table_axis, kStandAxisNames);
  field("reference_degC", term.reference_degC);
  field("covariate", term.covariate);
  field("covariate_mean", term.covariate_mean, NeverNull{});
  field("factors", term.factors);
  field("offsets", term.offsets);
  field("knots", term.knots);
  // Files of before it was carried do not say what an effect was chosen on.
  field(Later("chosen_on"), term.chosen_on, NamesUpTo(ChosenOn::kAllData));
  field.Check([&](const Place& place) { CheckTerm(term, place); });
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ChannelCalibration>& channel) {
  auto& model = channel.model;
  field("gyro", model.axis, kSensorAxisNames);
  field("unit", model.unit);
  field("units_per_deg_s", model.units_per_deg_s, AboveZero{});
  field("m_row", model.m_row, NeverNull{});
  field("m_row_std_error", model.m_row_std_error);
  field.Group("bias", [&](auto& bias) {
    bias("reference_degC", model.reference_degC);
    bias("coefficients_deg_s", model.bias_deg_s);
    bias.Check([&](const Place& place) { CheckBias(model, place); });
  });
  field("terms", model.terms);
  field("parameters", model.parameter_names);
  field("covariance", model.covariance, SquareOf{model.parameter_names.size()});
  field.Group("validity", [&](auto& validity) {
    validity("min_temperature_degC", model.min_temperature_degC);
    validity("max_temperature_degC", model.max_temperature_degC);
    validity("max_rate_deg_s", model.max_rate_deg_s);
  });
  field("verdict", channel.verdict, NamesUpTo(Verdict::kUnexplained));
  field("heldout_whitened_rms", channel.heldout_whitened_rms);
  field("heldout_angle_rms_deg", channel.heldout_angle_rms_deg);
  // Files of before the noise was part of the format stay readable.
  field.Group(Later("noise"), [&](auto& noise) { RandomWalks(noise, channel.noise); });
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, Calibration>& calibration) {
  field.Constant("format", kCalibrationFormat);
  field.Derived("model", [] {
    return "xi / s0 = sum_j M_j w_j + sum_k b_k (T - T0)^k + sum of terms [deg/s]; gyrobench's "
           "docs/calibration.md";
  });
  field("sensor", calibration.sensor);
  field("created", calibration.created);
  field("version", calibration.version);
  field("inputs", calibration.inputs);
  field("configuration", calibration.configuration);
  field("channels", calibration.channels);
  field.Check([&](const Place& place) { CheckChannels(calibration, place); });
  // Files of before the zero was carried, or the axes were joined, stay readable.
  field(Later("gyro_lsb_zero"), calibration.gyro_lsb_zero);
  field.IfThere("vector", calibration.vector);
}

}  // namespace gyrobench::calibration
