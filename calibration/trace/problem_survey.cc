// What happened in all rows of a channel's problem together: what turned, how far, and what can be
// seen by it.
#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

constexpr double kLeastTablePath_deg = 20.0;
// A quarter of a turn about another axis, square to the channel's.
constexpr double kLeastPathByError = 1.5;

}  // namespace

void ChannelProblem::Survey() {
  constexpr double kFelt = 0.2;  // as a lever
  // Of each axis: the turns that are felt, its own, and what an error of 1 deg makes.
  Vector3 felt_path_deg = {}, path_deg = {}, path_by_error = {};
  double motion_s = 0.0;
  feels_table_.assign(rows_.size(), false);
  felt_axes_.reserve(rows_.size());
  bool gravity = !histories_.empty(), temperature = gravity, vibration = gravity;
  for (const StateHistory& history : histories_) {
    gravity = gravity && history.gravity_known;
    temperature = temperature && history.temperature_known;
    vibration = vibration && history.vibration_known;
  }
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const double dt = intervals_[static_cast<std::size_t>(i)].duration_s;
    felt_axes_.push_back(FeelAxes(history(i), ref(i).interval, channel_));
    for (std::size_t h = 0; h < 2; ++h) {
      const SensorState& point = half(i, h);
      max_rate_ = std::max(max_rate_, std::fabs(point.rate_deg_s[channel_]));
      gravity = gravity && std::isfinite(point.gravity_g[0]);
    }
    if (!half(i, 0).still) motion_s += dt;
    for (std::size_t c = 0; c < 3 && !half(i, 0).still; ++c)
      path_[c] += std::fabs(history(i).rotation_deg[ref(i).interval][c]);
    for (std::size_t a = 0; a < 3; ++a) {
      const double lever = std::fabs(AxisProjection(i, a));
      const double turned_deg = std::fabs(half(i, 0).table_rate_deg_s[a]) * dt;
      path_deg[a] += turned_deg;
      path_by_error[a] += std::fabs(felt_axes_.back()[a].direction);
      if (!(lever > kFelt) || turned_deg == 0.0) continue;
      felt_path_deg[a] += turned_deg * lever;
      feels_table_[static_cast<std::size_t>(i)] = true;
    }
  }
  mean_rate_in_motion_ = motion_s > 0.0 ? path_[channel_] / motion_s : 0.0;
  SurveyTurns();
  SurveyTemperature();
  SurveyGravity();
  SurveyRounding();
  for (std::size_t a = 0; a < 3; ++a) {
    const bool turns = felt_path_deg[a] > kLeastTablePath_deg;
    if (turns) table_axes_.push_back(a);
    if (turns || (path_deg[a] > kLeastTablePath_deg && path_by_error[a] > kLeastPathByError))
      axes_with_felt_errors_.push_back(a);
  }
  auto bit = [](bool known, unsigned need) { return known ? need : 0u; };
  temperature_known_ = temperature;
  observables_ =
      bit(TurnsByItself(), kNeedsRate) | bit(gravity, kNeedsGravity) |
      bit(temperature && max_temperature_ - min_temperature_ >= kLeastTemperatureRange_degC,
          kNeedsTemperature) |
      bit(!table_axes_.empty(), kNeedsTableAxis) | bit(vibration, kNeedsVibration) |
      bit(PowerOnIsKnown(), kNeedsPowerOn) | bit(gear_ratio() > 0.0, kNeedsGear);
}

// A table of rests alone, cut from somewhere, does not say when the sensor was switched on.
bool ChannelProblem::PowerOnIsKnown() const {
  return std::ranges::all_of(histories_, [](const StateHistory& history) {
    const MeasurementInfo& info = history.recording->info;
    return info.reference != ReferenceKind::kNone || !info.power_on.empty();
  });
}

// Range, and mean over the time.
void ChannelProblem::SurveyTemperature() {
  double sum = 0.0, time_s = 0.0;
  for (Eigen::Index i = 0; i < rows(); ++i) {
    const double half_s = 0.5 * intervals_[static_cast<std::size_t>(i)].duration_s;
    for (std::size_t h = 0; h < 2; ++h) {
      const double temperature = half(i, h).temperature_degC;
      min_temperature_ = std::fmin(min_temperature_, temperature);
      max_temperature_ = std::fmax(max_temperature_, temperature);
      sum += half_s * temperature;
      time_s += half_s;
    }
  }
  mean_temperature_ = sum / time_s;
}

void ChannelProblem::SurveyGravity() {
  Vector3 low = {kMissing, kMissing, kMissing}, high = low;
  for (Eigen::Index i = 0; i < rows(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      low[c] = std::fmin(low[c], half(i, 0).gravity_g[c]);
      high[c] = std::fmax(high[c], half(i, 0).gravity_g[c]);
    }
  }
  for (std::size_t c = 0; c < 3; ++c) gravity_range_[c] = high[c] - low[c];
}

void ChannelProblem::SurveyRounding() {
  for (std::size_t a = 0; a < 3; ++a) {
    std::vector<RestFlicker> rests;
    for (const StateHistory& history : histories_) rests.push_back(history.rest_flicker[a]);
    rounding_wave_deg_[a] = WaveOfRounding_deg(rests);
  }
}

}  // namespace gyrobench::calibration
