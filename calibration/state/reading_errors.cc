// What the mean of several readings of the reference is worth.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <vector>

#include "base/robust.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

// Half of the readings are in rests that scatter no more than that: the turns that pass for rests
// are many and short.
double MedianScatter(std::vector<Rest> rests) {
  std::ranges::sort(rests, {}, &Rest::scatter_deg);
  std::int64_t left = 0;
  for (const Rest& rest : rests) left += rest.readings;
  left /= 2;
  for (const Rest& rest : rests) {
    left -= rest.readings;
    if (left <= 0) return rest.scatter_deg;
  }
  return rests.back().scatter_deg;
}

}  // namespace

ReadingErrors::ReadingErrors(const Recording& recording, const std::vector<Node>& nodes,
                             const std::vector<std::size_t>& rest_of)
    : step_deg_(recording.reference_step_deg) {
  const bool rests = !recording.columns.rests.empty();
  if (rests) scatter_deg_ = MedianScatter(recording.columns.rests);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    flicker_[axis] = FlickerAtRest(nodes, rest_of, axis, step_deg_[axis]);
    if (rests) rounded_[axis] = LeftOfRounding(flicker_[axis]);
  }
}

double ReadingErrors::RoundingOf_deg(std::size_t axis) const {
  return rounded_[axis] > 0.0 ? 0.5 * std::sqrt(rounded_[axis]) * step_deg_[axis] : 0.0;
}

// Rounding errs by half a step at most, evenly.
double ReadingErrors::ErrorInMotion_deg(double readings) const {
  return std::max(scatter_deg_ / std::sqrt(readings), LargestRounding_deg() / std::numbers::sqrt3);
}

double ReadingErrors::MostInMotion_deg(double readings) const {
  return std::max(ErrorInMotion_deg(readings), LargestRounding_deg());
}

double ReadingErrors::LargestRounding_deg(double least_left) const {
  double most_deg = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (rounded_[axis] > least_left) most_deg = std::max(most_deg, RoundingOf_deg(axis));
  }
  return most_deg;
}

// Of each node: at how many in a row the axis is within half a count of what it is there. Where a
// rest is among them, as many as there are beside all rests on its count, which are one each. That
// of nodes in motion is divided by its harmonic mean over those where the axis itself turns and no
// rest is beside: what readings next to each other show of their errors is then as large as it is.
std::vector<double> ReadingErrors::Alike(const std::vector<Node>& epochs, const RestReadings& rests,
                                         std::size_t axis) const {
  constexpr std::size_t kMost = 50;  // either way
  std::vector<double> alike(epochs.size(), 1.0);
  const double step_deg = step_deg_[axis];
  if (!(rounded_[axis] > 0.0) || !std::isfinite(step_deg)) return alike;
  const auto moves = [&](std::size_t k) { return rests.rest_of[k] == kNoRest; };
  const auto near = [&](std::size_t k, std::size_t j) {
    return std::fabs(epochs[j].table_deg[axis] - epochs[k].table_deg[axis]) < 0.5 * step_deg;
  };
  const auto count_of = [&](std::size_t k) {
    return std::round(rests.angle_deg[rests.rest_of[k]][axis] / step_deg);
  };
  std::map<double, double> on_count;
  std::vector<double> beside(epochs.size(), kMissing);  // count of a rest
  std::vector<bool> turns(epochs.size(), false);
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    if (!moves(k)) {
      beside[k] = count_of(k);
      if (!std::isfinite(beside[k])) continue;
      on_count[beside[k]] += k == 0 || rests.rest_of[k - 1] != rests.rest_of[k] ? 1.0 : 0.0;
      continue;
    }
    std::size_t begin = k, end = k;
    while (begin > 0 && k - begin < kMost && moves(begin) && near(k, begin - 1)) --begin;
    while (end + 1 < epochs.size() && end - k < kMost && moves(end) && near(k, end + 1)) ++end;
    alike[k] = static_cast<double>(end + 1 - begin);
    turns[k] = k - begin < kMost && end - k < kMost;
    if (!moves(begin)) beside[k] = count_of(begin);
    if (!moves(end)) beside[k] = count_of(end);
    if (std::isfinite(beside[k])) on_count[beside[k]] += 1.0;
  }
  double inverse = 0.0, count = 0.0;
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    if (std::isfinite(beside[k])) alike[k] = on_count[beside[k]];
    if (!turns[k] || std::isfinite(beside[k])) continue;
    inverse += 1.0 / alike[k];
    count += 1.0;
  }
  for (std::size_t k = 0; k < epochs.size(); ++k) {
    if (moves(k) && count > 0.0) alike[k] *= inverse / count;
  }
  return alike;
}

double ReadingErrors::ShareInMotion(const std::vector<Node>& epochs, std::size_t k,
                                    std::size_t axis, double alike) const {
  double readings = 1.0, steps = 0.0;
  if (const ReadingsMean& mean = epochs[k].mean; mean.output_known) {
    const Vector3& own = mean.own_readings;
    // Of an orientation there are no readings of one axis.
    const bool of_axes = own[0] + own[1] + own[2] > 0.0;
    readings = of_axes ? std::max(own[axis], 1.0) : mean.readings;
    const Vector3& from_deg = epochs[k > 0 ? k - 1 : k].table_deg;
    for (std::size_t a = 0; a < 3; ++a) {
      const double passed = std::fabs(epochs[k].table_deg[a] - from_deg[a]) / step_deg_[a];
      if (std::isfinite(passed)) steps = std::max(steps, passed);
    }
  }
  const double rounded = rounded_[axis];
  return rounded * alike / std::min(readings, 1.0 + steps) + (1.0 - rounded) / readings;
}

std::vector<Vector3> ReadingErrors::Shares(const std::vector<Node>& epochs,
                                           const RestReadings& rests) const {
  // The error of a mean over a rest does not fall for ever: what is not noise stays.
  constexpr double kLeastShare = 0.005;
  std::vector<Vector3> shares(epochs.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<double> alike = Alike(epochs, rests, axis);
    for (std::size_t k = 0; k < epochs.size(); ++k) {
      if (const std::size_t rest = rests.rest_of[k]; rest == kNoRest) {
        shares[k][axis] = ShareInMotion(epochs, k, axis, alike[k]);
      } else {
        const double of_noise = (1.0 - rounded_[axis]) / rests.readings[rest];
        shares[k][axis] = std::max(kLeastShare, rounded_[axis] * alike[k] + of_noise);
      }
    }
  }
  return shares;
}

}  // namespace gyrobench::calibration
