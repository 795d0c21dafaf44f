#include <algorithm>
#include <cmath>

#include "calibration/trace/smooth.h"
#include "calibration/trace/trail_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kTemperatureHalfWindow_s = 5.0;

}  // namespace

void FillTemperature(const Recording& recording, Trail* trail) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  std::vector<double> t_s, value;
  std::size_t known = 0;
  for (const Node& node : nodes) {
    t_s.push_back(node.at.t_s);
    value.push_back(node.temperature_degC);
    known += std::isfinite(node.temperature_degC) ? 1U : 0U;
  }
  if (known < 2 || 10 * known < nodes.size()) return;
  const Smoothed smooth = SmoothByLines(t_s, value, kTemperatureHalfWindow_s);
  // Without a value near, the last known one.
  double last = kMissing, last_rate = 0.0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (std::isfinite(smooth.value[k])) {
      last = smooth.value[k];
      last_rate = smooth.rate[k];
    }
    trail->nodes[k].temperature_degC = last;
    trail->nodes[k].temperature_rate_degC_s = last_rate;
  }
  for (std::size_t k = nodes.size(); k-- > 0;) {
    if (std::isfinite(trail->nodes[k].temperature_degC)) continue;
    trail->nodes[k].temperature_degC = trail->nodes[k + 1].temperature_degC;
  }
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    for (std::size_t h = 0; h < 2; ++h) {
      const double part = 0.25 + 0.5 * static_cast<double>(h);
      TrackPoint& half = trail->halves[2 * i + h];
      const TrackPoint& a = trail->nodes[i];
      const TrackPoint& b = trail->nodes[i + 1];
      half.temperature_degC = a.temperature_degC + part * (b.temperature_degC - a.temperature_degC);
      half.temperature_rate_degC_s = a.temperature_rate_degC_s +
                                     part * (b.temperature_rate_degC_s - a.temperature_rate_degC_s);
    }
  }
  trail->temperature_known = true;
}

void FillCovariates(const Recording& recording, const std::vector<std::string>& covariates,
                    Trail* trail) {
  const std::vector<Node>& nodes = recording.columns.nodes;
  trail->vibration_known = true;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    trail->nodes[k].vibration_g2 = nodes[k].vibration_g2;
    if (k == 0) continue;
    if (!std::isfinite(nodes[k].vibration_g2)) trail->vibration_known = false;
    for (std::size_t h = 0; h < 2; ++h)
      trail->halves[2 * (k - 1) + h].vibration_g2 = nodes[k].vibration_g2;
  }
  const std::size_t count = covariates.size();
  if (count == 0) return;
  // The mean up to a node is that of its interval: both halves have it.
  trail->covariates.resize(nodes.size() * count);
  const std::vector<std::string>& names = recording.info.covariates;
  for (std::size_t j = 0; j < count; ++j) {
    const auto from = static_cast<std::size_t>(
        std::find(names.begin(), names.end(), covariates[j]) - names.begin());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      trail->covariates[k * count + j] = recording.columns.covariates[k * names.size() + from];
    }
  }
  std::vector<double> last(count, kMissing);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    for (std::size_t j = 0; j < count; ++j) {
      double& value = trail->covariates[k * count + j];
      if (std::isfinite(value)) last[j] = value;
      value = last[j];
    }
  }
  for (std::size_t k = nodes.size(); k-- > 0;) {
    for (std::size_t j = 0; j < count; ++j) {
      double& value = trail->covariates[k * count + j];
      if (!std::isfinite(value) && k + 1 < nodes.size())
        value = trail->covariates[(k + 1) * count + j];
    }
  }
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const double* values = trail->covariates.data() + k * count;
    trail->nodes[k].covariates = values;
    if (k == 0) continue;
    trail->halves[2 * k - 2].covariates = trail->halves[2 * k - 1].covariates = values;
  }
}

}  // namespace gyrobench::calibration
