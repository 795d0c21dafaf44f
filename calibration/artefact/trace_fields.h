// The lists of fields of a trace: docs/trace.md.
#pragma once

#include <cmath>

#include "base/measurement_fields.h"
#include "calibration/artefact/trace_json.h"
#include "calibration/artefact/vector_fields.h"

namespace gyrobench::calibration {

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, TraceInput>& input) {
  field("file", input.file);
  field("samples", input.samples);
  field("duration_s", input.duration_s);
  field("defects", input.defects);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ModelParameter>& parameter) {
  field("name", parameter.name);
  field("value", parameter.value);
  field("unit", parameter.unit);
  field("std_error", parameter.std_error);
  field("bound", parameter.bound);
  field("statistical_std_error", parameter.statistical_std_error,
        InsteadOfNull{parameter.std_error});
  field.IfThere("because", parameter.because);
}

template <typename Visitor>
void BeforeAndAfter(Visitor& field, FieldsOf<Visitor, HeldOut>& figure) {
  field("before", figure.before);
  field("after", figure.after);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, HeldOut>& figure) {
  BeforeAndAfter(field, figure);
  field("reduction_ci95", figure.reduction_ci95);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, TracedEffect>& effect) {
  field("id", effect.id);
  field("origin", effect.origin, NamesUpTo(EffectOrigin::kEmpirical));
  field("owner", effect.owner, NamesUpTo(EffectOwner::kBench));
  field("equation", effect.equation);
  field("cause", effect.cause);
  field("parameters", effect.parameters);
  field("p_value", effect.p_value);
  field("rivals", effect.rivals);
  field("settled_by", effect.settled_by);
  field("chosen_on", effect.chosen_on, NamesUpTo(ChosenOn::kAllData));
  field("heldout_whitened_rms", effect.heldout_whitened_rms);
  field("heldout_angle_rms_deg", effect.heldout_angle_rms_deg);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, Unidentifiable>& unidentifiable) {
  field("id", unidentifiable.id);
  field("because", unidentifiable.because);
  field("settled_by", unidentifiable.settled_by);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, Finding>& finding) {
  field("test", finding.test);
  field("covariate", finding.covariate);
  field("p_value", finding.p_value);
  field("says", finding.says);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ChannelTrace::Baseline>& baseline) {
  field("parameters", baseline.parameters);
  field("reference_degC", baseline.reference_degC);
  field("whitened_rms", baseline.whitened_rms);
  field("angle_rms_deg", baseline.angle_rms_deg);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ChannelTrace::Remaining>& remaining) {
  field("white", remaining.white);
  field("findings", remaining.findings);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, ChannelTrace>& channel) {
  field("gyro", channel.axis, kSensorAxisNames);
  field("verdict", channel.verdict, NamesUpTo(Verdict::kCannotBe));
  field("summary", channel.summary);
  field("baseline", channel.baseline);
  field("effects", channel.effects);
  field("heldout_whitened_rms", channel.heldout_whitened_rms);
  field("heldout_angle_rms_deg", channel.heldout_angle_rms_deg);
  // Where the data were too few to be divided, no part of them asked for anything.
  field("training_effects", channel.training_effects,
        NullUnless{std::isfinite(channel.heldout_whitened_rms.after)});
  field("forecast_angle_rms_deg", channel.forecast_angle_rms_deg);
  field.Group("fitted_whitened_rms",
              [&](auto& part) { BeforeAndAfter(part, channel.fitted_whitened_rms); });
  field.Group("fitted_angle_rms_deg",
              [&](auto& part) { BeforeAndAfter(part, channel.fitted_angle_rms_deg); });
  field("unidentifiable", channel.unidentifiable);
  field("remaining", channel.remaining);
  field("noise", channel.noise);
  field("remarks", channel.remarks);
}

template <typename Visitor>
void Fields(Visitor& field, FieldsOf<Visitor, TraceResult>& result) {
  field.Constant("format", kTraceFormat);
  field("inputs", result.inputs);
  field("channels", result.channels);
  field("vector", result.vector);
  field.Group("reference_error", [&](auto& part) {
    part("says", result.reference_error);
    part("relative_std_uncertainty", result.reference_uncertainty);
  });
  field("remarks", result.remarks);
}

}  // namespace gyrobench::calibration
