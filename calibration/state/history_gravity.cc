#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/geometry.h"
#include "calibration/state/history_parts.h"

namespace gyrobench::calibration {
namespace {

constexpr double kAccelDisagrees_deg = 10.0;

Vector3 Normalised(const Vector3& v) {
  const double norm = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  return {v[0] / norm, v[1] / norm, v[2] / norm};
}

// Between two directions that are not far apart.
Vector3 Between(const Vector3& a, const Vector3& b, double part) {
  Vector3 out;
  for (std::size_t c = 0; c < 3; ++c) out[c] = (1.0 - part) * a[c] + part * b[c];
  return Normalised(out);
}

// v, given in the frame at angle 0 about axis `axis`, in the frame turned by the angle.
Vector3 TurnedBack(const Vector3& v, std::size_t axis, double angle_deg) {
  const double angle = angle_deg * kRadPerDeg;
  const std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
  Vector3 out = v;
  out[i] = std::cos(angle) * v[i] + std::sin(angle) * v[j];
  out[j] = -std::sin(angle) * v[i] + std::cos(angle) * v[j];
  return out;
}

bool Finite(const Vector3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

// One axis turns, the accelerometer turns with it: taken back to angle 0 it must say the same
// all the time.
void GravityFromAccelerometer(const std::vector<Node>& nodes, std::size_t axis,
                              StateHistory* history) {
  Vector3 sum = {};
  double count = 0.0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vector3& a = nodes[k].accel_g;
    if (!Finite(a) || !std::isfinite(nodes[k].table_deg[axis])) continue;
    const Vector3 back = TurnedBack(a, axis, -nodes[k].table_deg[axis]);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += back[c];
    count += 1.0;
  }
  if (count < 10.0) return;
  for (double& part : sum) part /= count;
  const double size = std::hypot(sum[0], sum[1], sum[2]);
  if (size < 0.5 || size > 1.5) {
    history->remarks.push_back(
        fmt::format("the accelerometer shows {:.2f} g where 1 g is expected: gravity in the "
                    "sensor's frame is not known, its effects are not looked for",
                    size));
    return;
  }
  sum = Normalised(sum);
  for (SensorState& point : history->nodes)
    point.gravity_g = TurnedBack(sum, axis, point.table_deg[axis]);
  history->gravity_known = true;
}

void GravityByPose(const std::vector<std::size_t>& rest_of, StateHistory* history) {
  const std::vector<Node>& nodes = history->epochs;
  std::size_t rests = 0;
  for (const std::size_t rest : rest_of)
    rests = rest == kNoRest ? rests : std::max(rests, rest + 1);
  std::vector<Vector3> sum(rests, Vector3{});
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (rest_of[k] == kNoRest || !Finite(nodes[k].accel_g)) continue;
    for (std::size_t c = 0; c < 3; ++c) sum[rest_of[k]][c] += nodes[k].accel_g[c];
  }
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    if (rest_of[k] == kNoRest) continue;
    const Vector3 direction = Normalised(sum[rest_of[k]]);
    if (!Finite(direction)) continue;
    history->nodes[k].gravity_g = direction;
    history->gravity_known = true;
  }
}

// Gravity comes from the reference; the accelerometer is its witness.
void CompareWithAccelerometer(const std::vector<Node>& nodes, StateHistory* history) {
  double product = 0.0, count = 0.0;
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const Vector3& a = nodes[k].accel_g;
    if (!Finite(a) || std::hypot(a[0], a[1], a[2]) < 0.5) continue;
    const Vector3 direction = Normalised(a);
    const Vector3& g = history->nodes[k].gravity_g;
    if (!Finite(g)) continue;  // before the first reading of all axes
    product += direction[0] * g[0] + direction[1] * g[1] + direction[2] * g[2];
    count += 1.0;
  }
  if (count < 10.0) return;
  const double off_deg = std::acos(std::clamp(product / count, -1.0, 1.0)) * kDegPerRad;
  if (!(off_deg >= kAccelDisagrees_deg)) return;
  history->remarks.push_back(fmt::format(
      "the accelerometer points {:.0f} deg away from the gravity that the reference says: check "
      "how the sensor is mounted (on a stand: mount_x_deg and its like); effects of gravity are "
      "taken by the reference",
      off_deg));
}

}  // namespace

void FillGravity(const Recording& recording, const std::vector<std::size_t>& rest_of,
                 StateHistory* history) {
  const std::vector<Node>& nodes = history->epochs;
  const ReferenceKind kind = recording.info.reference;
  if (kind == ReferenceKind::kStandAngles || kind == ReferenceKind::kOrientation) {
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      history->nodes[k].gravity_g = nodes[k].world_z;
      history->nodes[k].world_x = nodes[k].world_x;
    }
    history->gravity_known = !nodes.empty() && Finite(nodes.back().world_z);
    if (history->gravity_known) CompareWithAccelerometer(nodes, history);
  } else if (kind == ReferenceKind::kSensorAngle) {
    GravityFromAccelerometer(nodes, static_cast<std::size_t>(recording.info.reference_axis),
                             history);
  } else {
    GravityByPose(rest_of, history);
  }
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const SensorState& a = history->nodes[i];
    const SensorState& b = history->nodes[i + 1];
    for (std::size_t h = 0; h < 2; ++h) {
      const double part = 0.25 + 0.5 * static_cast<double>(h);
      history->midpoints[2 * i + h].gravity_g = Between(a.gravity_g, b.gravity_g, part);
      history->midpoints[2 * i + h].world_x = Between(a.world_x, b.world_x, part);
    }
  }
}

}  // namespace gyrobench::calibration
