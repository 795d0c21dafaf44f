#include "calibration/state/slow_state.h"

#include <algorithm>
#include <cmath>

#include "calibration/state/slow_quantity.h"

namespace gyrobench::calibration {
namespace {

// The length of a specific force that can be gravity's.
constexpr double kLeast_g = 0.5, kMost_g = 1.5;
constexpr double kLeastVibrationSamples = 4.0;

double Blend(double a, double b, double part) {
  // Equal ends first: NaN on one side must not spoil what is known exactly.
  return part <= 0.0 ? a : a + part * (b - a);
}

}  // namespace

void SlowState::Mean::Add(double value) {
  if (!std::isfinite(value)) return;
  sum += value;
  n += 1.0;
}

double SlowState::Mean::Take() {
  const double mean = n > 0.0 ? sum / n : kMissing;
  *this = {};
  return mean;
}

SlowState::SlowState(std::size_t covariates)
    : columns_(1 + covariates), now_(covariates, kMissing) {}

void SlowState::Add(const GyroSample& sample, std::span<const double> covariates) {
  if (open_ && sample.t_s - begin_s_ >= kNode_s) CloseNode();
  if (!open_) {
    open_ = true;
    begin_s_ = sample.t_s;
    origin_ = sample.accel_g;
  }
  last_s_ = sample.t_s;
  columns_[0].mean.Add(sample.temperature_degC);
  for (std::size_t c = 0; c < 3; ++c) {
    const double offset = sample.accel_g[c] - origin_[c];
    accel_[c].Add(sample.accel_g[c]);
    square_[c].Add(offset * offset);
  }
  for (std::size_t i = 0; i < std::min(covariates.size(), now_.size()); ++i)
    columns_[1 + i].mean.Add(covariates[i]);
}

// The mean direction; without one, the last.
Vector3 SlowState::TakeGravity() {
  Vector3 mean;
  for (std::size_t c = 0; c < 3; ++c) mean[c] = accel_[c].Take();
  const double size = std::hypot(mean[0], mean[1], mean[2]);
  if (size >= kLeast_g && size <= kMost_g) {
    for (std::size_t c = 0; c < 3; ++c) held_gravity_[c] = mean[c] / size;
  }
  return held_gravity_;
}

double SlowState::TakeVibration() {
  const bool vibrates = accel_[0].n >= kLeastVibrationSamples && accel_[1].n == accel_[0].n &&
                        accel_[2].n == accel_[0].n;
  double scatter = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const double offset = accel_[c].sum / accel_[c].n - origin_[c];
    scatter += square_[c].Take() - offset * offset;
  }
  return vibrates ? scatter : kMissing;
}

void SlowState::CloseNode() {
  Node node;
  node.t_s = 0.5 * (begin_s_ + last_s_);
  node.end_s = last_s_;
  node.vibration_g2 = TakeVibration();
  node.gravity_g = TakeGravity();
  for (Column& column : columns_) node.value.push_back(column.mean.Take());
  node.tellable.assign(columns_.size(), false);
  nodes_.push_back(std::move(node));
  open_ = false;
  for (std::size_t j = 0; j < columns_.size(); ++j) Settle(j);
  Smooth();
}

// What the newest node says of a column there and in the gap before it. The smoothing bridges short
// gaps of the temperature by itself.
void SlowState::Settle(std::size_t j) {
  Column& column = columns_[j];
  Node& newest = nodes_.back();
  const double value = newest.value[j], gap_s = newest.t_s - column.last_s;
  if (!std::isfinite(value)) {
    newest.tellable[j] = gap_s <= kNearKnown_s;
    if (newest.tellable[j] && j > 0) newest.value[j] = column.last;
    return;
  }
  const bool bridge = gap_s <= kLongestBridge_s;
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    Node& node = nodes_[i];
    if (node.t_s <= column.last_s || (!bridge && newest.t_s - node.t_s > kNearKnown_s)) break;
    node.tellable[j] = true;
    if (&node == &newest) continue;
    if (bridge && (j > 0 || gap_s > kHalfWindow_s)) {
      node.value[j] = Blend(column.last, value, (node.t_s - column.last_s) / gap_s);
    } else if (j > 0) {
      node.value[j] = value;
    }
  }
  column.last_s = newest.t_s;
  column.last = value;
}

// Up to here no column waits for the end of a gap.
double SlowState::SettledUntil() const {
  double until_s = nodes_.back().t_s;
  for (const Column& column : columns_) {
    if (nodes_.back().t_s - column.last_s <= kLongestBridge_s)
      until_s = std::min(until_s, column.last_s);
  }
  return until_s;
}

void SlowState::End() {
  if (open_) CloseNode();
  ended_ = true;
  Smooth();
}

// Lines through all nodes that are held; those whose window is whole are done with.
void SlowState::Smooth() {
  if (smooth_ == nodes_.size()) return;
  const double until_s = SettledUntil();
  const auto is_whole = [&](const Node& node) {
    return ended_ || until_s - node.t_s > kHalfWindow_s;
  };
  if (!is_whole(nodes_[smooth_])) return;
  std::vector<double> t_s, value;
  for (const Node& node : nodes_) {
    t_s.push_back(node.t_s);
    value.push_back(node.value[0]);
  }
  const Smoothed lines = SmoothByLines(t_s, value, kHalfWindow_s);
  for (; smooth_ < nodes_.size() && is_whole(nodes_[smooth_]); ++smooth_) {
    if (!nodes_[smooth_].tellable[0]) continue;
    nodes_[smooth_].smooth_degC = lines.value[smooth_];
    nodes_[smooth_].rate_degC_s = lines.rate[smooth_];
  }
}

bool SlowState::Knows(double t_s) const {
  return ended_ || (smooth_ > 0 && nodes_[smooth_ - 1].t_s >= t_s);
}

void SlowState::At(double t_s, SensorState* point) {
  // What lies further back than any window to come is let go.
  while (
      smooth_ > 2 && nodes_[1].t_s <= t_s &&
      (smooth_ == nodes_.size() || nodes_[smooth_].t_s - nodes_[1].t_s > kHalfWindow_s + kNode_s)) {
    nodes_.pop_front();
    --smooth_;
  }
  if (smooth_ == 0) return;
  const auto end = nodes_.begin() + static_cast<std::ptrdiff_t>(smooth_);
  auto after = std::upper_bound(nodes_.begin(), end, t_s,
                                [](double t, const Node& node) { return t < node.t_s; });
  const Node& a = after == nodes_.begin() ? *after : *(after - 1);
  const Node& b = after == end ? a : *after;
  const double part = b.t_s > a.t_s ? (t_s - a.t_s) / (b.t_s - a.t_s) : 0.0;
  point->temperature_degC = Blend(a.smooth_degC, b.smooth_degC, part);
  // Half a node before the first and after the last.
  if (&a == &b || part < 0.0) {
    const double beyond_s = std::clamp(t_s - a.t_s, -kNode_s, kNode_s);
    if (std::isfinite(a.rate_degC_s))
      point->temperature_degC = a.smooth_degC + a.rate_degC_s * beyond_s;
  }
  point->temperature_rate_degC_s = Blend(a.rate_degC_s, b.rate_degC_s, part);
  // A mean square belongs to all of its interval.
  point->vibration_g2 = t_s <= a.end_s ? a.vibration_g2 : b.vibration_g2;
  for (std::size_t c = 0; c < 3; ++c)
    point->gravity_g[c] = Blend(a.gravity_g[c], b.gravity_g[c], part);
  const double size = std::hypot(point->gravity_g[0], point->gravity_g[1], point->gravity_g[2]);
  for (double& part_of : point->gravity_g) part_of /= size;
  for (std::size_t i = 0; i < now_.size(); ++i)
    now_[i] = Blend(a.value[1 + i], b.value[1 + i], part);
  point->covariates = now_.data();
}

}  // namespace gyrobench::calibration
