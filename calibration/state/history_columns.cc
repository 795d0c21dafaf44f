#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibration/state/history_parts.h"
#include "calibration/state/slow_quantity.h"

namespace gyrobench::calibration {
namespace {

constexpr double kTemperatureHalfWindow_s = 5.0;

// Takes out the intervals that end or begin where a column cannot be told, and says so.
void LeaveOut(const std::vector<double>& t_s, const std::vector<bool>& tellable,
              const std::string& what, const std::string& kind, StateHistory* history) {
  Defect defect{kind, 0, kMissing, what};
  double missing_s = 0.0;
  for (std::size_t i = 0; i + 1 < t_s.size(); ++i) {
    if (tellable[i] && tellable[i + 1]) continue;
    history->usable[i] = {false, false, false};
    if (defect.count++ == 0) defect.first_t_s = t_s[i];
    missing_s += t_s[i + 1] - t_s[i];
  }
  if (defect.count == 0) return;
  history->remarks.push_back(
      fmt::format("{}: {} is missing for {:.1f} s, first at {:.1f} s, in gaps too long to be "
                  "bridged: these stretches are left out",
                  history->name, what, missing_s, defect.first_t_s));
  history->defects.push_back(std::move(defect));
}

// Value and rate where the temperature can be told, NaN elsewhere.
Smoothed SmoothTemperature(const std::vector<double>& t_s, std::vector<double> value,
                           const std::vector<bool>& tellable) {
  // Within its window the smoother needs no bridge.
  BridgeGaps(t_s, kTemperatureHalfWindow_s, &value);
  Smoothed smooth = SmoothByLines(t_s, value, kTemperatureHalfWindow_s);
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    if (!tellable[k]) smooth.value[k] = smooth.rate[k] = kMissing;
  }
  return smooth;
}

// Of means since the node before, `value`: those since the epoch before. In motion an epoch is the
// mean time of its readings, half an interval before its node.
std::vector<double> SinceEpochs(const std::vector<Node>& nodes, const std::vector<Node>& epochs,
                                std::vector<double> value) {
  for (std::size_t k = value.size(); k-- > 1;) {
    const double length_s = epochs[k].at.t_s - epochs[k - 1].at.t_s;
    const double before_s = nodes[k - 1].at.t_s - epochs[k - 1].at.t_s;
    if (!(before_s > 0.0) || !std::isfinite(value[k - 1])) continue;
    const double part = std::min(before_s / length_s, 1.0);
    value[k] = part * value[k - 1] + (1.0 - part) * value[k];
  }
  return value;
}

// What is missing is as before, or as after where nothing was before.
void Hold(std::vector<double>* value) {
  for (std::size_t k = 1; k < value->size(); ++k) {
    if (!std::isfinite((*value)[k])) (*value)[k] = (*value)[k - 1];
  }
  for (std::size_t k = value->size(); k-- > 1;) {
    if (!std::isfinite((*value)[k - 1])) (*value)[k - 1] = (*value)[k];
  }
}

// Where it is told for less than half of the time it is taken as unknown; what is missing beside is
// held, as vibration does not change from one epoch to the next.
void FillVibration(const std::vector<Node>& nodes, StateHistory* history) {
  std::vector<double> value;
  for (const Node& node : nodes) value.push_back(node.vibration_g2);
  const auto known =
      std::count_if(value.begin(), value.end(), [](double one) { return std::isfinite(one); });
  history->vibration_known =
      static_cast<double>(known) >= kLeastKnownShare * static_cast<double>(value.size() - 1);
  Hold(&value);
  value = SinceEpochs(nodes, history->epochs, std::move(value));
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    history->nodes[k].vibration_g2 = value[k];
    if (k == 0) continue;
    for (std::size_t h = 0; h < 2; ++h) history->midpoints[2 * (k - 1) + h].vibration_g2 = value[k];
  }
}

// A column without its short gaps; held within kNearKnown_s of a known value.
std::vector<double> WithoutGaps(const std::vector<double>& t_s, std::vector<double> value,
                                const std::vector<bool>& tellable) {
  BridgeGaps(t_s, 0.0, &value);
  for (std::size_t k = 1; k < value.size(); ++k) {
    if (tellable[k] && !std::isfinite(value[k])) value[k] = value[k - 1];
  }
  for (std::size_t k = value.size(); k-- > 1;) {
    if (tellable[k - 1] && !std::isfinite(value[k - 1])) value[k - 1] = value[k];
  }
  return value;
}

std::vector<double> EpochTimes(const StateHistory& history) {
  std::vector<double> t_s;
  for (const Node& epoch : history.epochs) t_s.push_back(epoch.at.t_s);
  return t_s;
}

}  // namespace

std::vector<double> NodeTimes(const Recording& recording) {
  std::vector<double> t_s;
  for (const Node& node : recording.columns.nodes) t_s.push_back(node.at.t_s);
  return t_s;
}

std::vector<double> TemperatureOf(const Recording& recording) {
  std::vector<double> value;
  for (const Node& node : recording.columns.nodes) value.push_back(node.temperature_degC);
  return value;
}

std::vector<double> CovariateOf(const Recording& recording, const std::string& name) {
  const std::vector<std::string>& names = recording.info.covariates;
  const auto column =
      static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  std::vector<double> out;
  for (std::size_t k = 0; k < recording.columns.nodes.size(); ++k)
    out.push_back(recording.columns.covariates[k * names.size() + column]);
  return out;
}

void FillTemperature(const Recording& recording, StateHistory* history) {
  if (!recording.info.temperature_present) return;
  const std::vector<double> t_s = EpochTimes(*history);
  if (t_s.size() < 2) return;  // of no time at all nothing is known, and that is said elsewhere
  std::vector<double> value = TemperatureOf(recording);
  const std::vector<bool> tellable = TellableTimes(t_s, value);
  const double share = TellableShare(t_s, tellable);
  if (share < kLeastKnownShare) {
    history->remarks.push_back(fmt::format(
        "{}: the temperature is known for {:.0f} % of the time, less than half: it is taken as "
        "unknown",
        history->name, 100.0 * share));
    return;
  }
  const Smoothed smooth = SmoothTemperature(t_s, std::move(value), tellable);
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    history->nodes[k].temperature_degC = smooth.value[k];
    history->nodes[k].temperature_rate_degC_s = smooth.rate[k];
  }
  for (std::size_t i = 0; i + 1 < t_s.size(); ++i) {
    for (std::size_t h = 0; h < 2; ++h) {
      const double part = 0.25 + 0.5 * static_cast<double>(h);
      SensorState& half = history->midpoints[2 * i + h];
      const SensorState& a = history->nodes[i];
      const SensorState& b = history->nodes[i + 1];
      half.temperature_degC = a.temperature_degC + part * (b.temperature_degC - a.temperature_degC);
      half.temperature_rate_degC_s = a.temperature_rate_degC_s +
                                     part * (b.temperature_rate_degC_s - a.temperature_rate_degC_s);
    }
  }
  history->temperature_known = true;
  LeaveOut(t_s, tellable, "temperature", "temperature_missing", history);
}

void FillCovariates(const Recording& recording, const std::vector<std::string>& covariates,
                    StateHistory* history) {
  FillVibration(recording.columns.nodes, history);
  const std::size_t count = covariates.size();
  if (count == 0) return;
  const std::vector<double> t_s = EpochTimes(*history);
  history->covariates.resize(t_s.size() * count);
  for (std::size_t j = 0; j < count; ++j) {
    std::vector<double> value = CovariateOf(recording, covariates[j]);
    const std::vector<bool> tellable = TellableTimes(t_s, value);
    value = SinceEpochs(recording.columns.nodes, history->epochs,
                        WithoutGaps(t_s, std::move(value), tellable));
    for (std::size_t k = 0; k < t_s.size(); ++k) history->covariates[k * count + j] = value[k];
    LeaveOut(t_s, tellable, "column " + covariates[j], "column_missing", history);
  }
  // The mean up to an epoch is that of its interval: both halves have it.
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    const double* values = history->covariates.data() + k * count;
    history->nodes[k].covariates = values;
    if (k == 0) continue;
    history->midpoints[2 * k - 2].covariates = history->midpoints[2 * k - 1].covariates = values;
  }
}

}  // namespace gyrobench::calibration
