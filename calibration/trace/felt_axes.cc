#include "base/geometry.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {
namespace {

Vector3 Column(const Matrix3& m, std::size_t a) { return {m[0][a], m[1][a], m[2][a]}; }

Vector3 Less(const Vector3& v, const Vector3& direction, double size) {
  return {v[0] - size * direction[0], v[1] - size * direction[1], v[2] - size * direction[2]};
}

Vector3 Cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

std::array<FeltAxis, 3> FeelAxes(const StateHistory& history, std::size_t interval,
                                 std::size_t channel) {
  std::array<FeltAxis, 3> felt;
  const MeasurementInfo& info = history.recording->info;
  if (info.reference == ReferenceKind::kSensorAngle) {
    const auto axis = static_cast<std::size_t>(info.reference_axis);
    felt[axis].turn = axis == channel ? 1.0 : 0.0;
  }
  if (info.reference != ReferenceKind::kStandAngles) return felt;
  const SensorState& half = history.midpoints[2 * interval];
  const Matrix3 directions = history.stand.Rates(half.table_deg);
  for (std::size_t a = 0; a < 3; ++a) felt[a].turn = directions[channel][a];
  if (history.still[interval]) return felt;

  // A vector outside of an axis with direction d, seen from within, turns by -d x v per radian.
  // Along d itself, as the axis's own motion is, that is nothing.
  const Vector3 inner = Column(directions, 2), middle = Column(directions, 1);
  const Vector3& whole_deg = history.rotation_deg[interval];
  const double length_s = history.nodes[interval + 1].t_s - history.nodes[interval].t_s;
  const Vector3 without_inner_deg = Less(whole_deg, inner, half.table_rate_deg_s[2] * length_s);
  felt[2].direction = -kRadPerDeg * Cross(inner, whole_deg)[channel];
  felt[1].direction = -kRadPerDeg * Cross(middle, without_inner_deg)[channel];
  return felt;
}

}  // namespace gyrobench::calibration
