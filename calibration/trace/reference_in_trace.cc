#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calibration/effects/effect.h"
#include "calibration/signal/reference_error.h"
#include "calibration/state/state_history.h"
#include "calibration/trace/channel_report.h"
#include "calibration/trace/report_parts.h"

namespace gyrobench::calibration {
namespace {

// The larger of what two inputs say; what only one says is not said of both.
std::optional<double> Larger(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return std::nullopt;
  return std::max(*a, *b);
}

bool HasReference(const StateHistory& history) {
  return history.recording->info.reference != ReferenceKind::kNone;
}

ReferenceUncertainty Said(std::span<const StateHistory> histories) {
  std::optional<ReferenceUncertainty> all;
  for (const StateHistory& history : histories) {
    if (!HasReference(history)) continue;
    const ReferenceUncertainty& one = history.recording->info.reference_uncertainty;
    all = !all ? one
               : ReferenceUncertainty{Larger(all->scale, one.scale),
                                      Larger(all->eccentricity_deg, one.eccentricity_deg),
                                      Larger(all->alignment_deg, one.alignment_deg)};
  }
  return all.value_or(ReferenceUncertainty{});
}

// Largest range of the rotation about each axis of the sensor among the inputs.
Vector3 Ranges_deg(std::span<const StateHistory> histories) {
  Vector3 range = {};
  for (const StateHistory& history : histories) {
    for (std::size_t c = 0; c < 3; ++c) {
      double low = 0.0, high = 0.0;
      for (const Node& node : history.recording->columns.nodes) {
        if (!std::isfinite(node.rotation_deg[c])) continue;
        low = std::min(low, node.rotation_deg[c]);
        high = std::max(high, node.rotation_deg[c]);
      }
      range[c] = std::max(range[c], high - low);
    }
  }
  return range;
}

ReferenceError ErrorOf(std::span<const StateHistory> histories, const ChannelTrace& trace) {
  ReferenceUncertainty said = Said(histories);
  const bool found = std::ranges::any_of(trace.effects, [](const TracedEffect& effect) {
    const Effect* known = FindEffect(effect.id);
    return known != nullptr && known->reference_eccentricity;
  });
  if (found && said.eccentricity_deg) said.eccentricity_deg = 0.0;
  return MakeReferenceError(said, Ranges_deg(histories));
}

// The axis of "scale_factor" and "cross_axis_zx", 3 of another parameter.
std::size_t AxisOf(const std::string& name, std::size_t channel) {
  if (name == "scale_factor") return channel;
  if (!name.starts_with("cross_axis_")) return 3;
  return static_cast<std::size_t>(name.back() - 'x');
}

}  // namespace

void AddReferenceError(std::span<const StateHistory> histories, std::size_t channel,
                       TracedChannel* traced) {
  const ReferenceError error = ErrorOf(histories, traced->trace);
  if (!error.said) return;
  traced->row.reference = error;
  ChannelModel& model = traced->model;
  Eigen::Vector3d row;
  for (Eigen::Index j = 0; j < 3; ++j) row(j) = model.m_row[static_cast<std::size_t>(j)];
  const Eigen::Matrix3d more = ReferenceCovariance(row, error);
  const auto variance = [&](std::size_t j) {
    return more(static_cast<Eigen::Index>(j), static_cast<Eigen::Index>(j));
  };
  const auto axis_of = [channel](const std::string& name) { return AxisOf(name, channel); };
  for (const std::string& name : model.parameter_names) {
    const std::size_t j = axis_of(name);
    if (j < 3)
      model.m_row_std_error[j] = std::hypot(model.m_row_std_error[j], std::sqrt(variance(j)));
  }
  AddToErrors(more, axis_of, &traced->trace.baseline.parameters);
  AddToCovariance(more, axis_of, &model);
}

void DescribeReferenceError(std::span<const StateHistory> histories, TraceResult* result) {
  if (std::none_of(histories.begin(), histories.end(), HasReference)) return;
  const ReferenceUncertainty said = Said(histories);
  if (!said.said()) {
    result->reference_error = kRelativeToReference;
    return;
  }
  const ReferenceError error = MakeReferenceError(said, Ranges_deg(histories));
  result->reference_uncertainty = 0.0;
  for (std::size_t c = 0; c < 3; ++c)
    result->reference_uncertainty = std::max(result->reference_uncertainty, error.OfScale(c));
  result->reference_error = fmt::format(
      "the errors of scale factors and matrix contain the reference's own uncertainty, {:.2g} of "
      "the scale factor at most{}",
      result->reference_uncertainty,
      said.scale ? "" : "; nothing is said of its scale, to which they are relative");
}

}  // namespace gyrobench::calibration
