#include <Eigen/Geometry>

#include "base/geometry.h"
#include "calibration/trace/problem.h"

namespace gyrobench::calibration {

std::array<FeltAxis, 3> FeelAxes(const StateHistory& history, std::size_t interval,
                                 std::size_t channel) {
  std::array<FeltAxis, 3> felt;
  const MeasurementInfo& info = history.recording->info;
  if (info.reference == ReferenceKind::kSensorAngle) {
    const auto axis = static_cast<std::size_t>(info.reference_axis);
    felt[axis].turn = axis == channel ? 1.0 : 0.0;
  }
  if (info.reference != ReferenceKind::kStandAngles) return felt;
  const SensorState &half = history.midpoints[2 * interval],
                    &later = history.midpoints[2 * interval + 1];
  const Matrix3 rows = history.stand.Rates(half.table_deg);
  for (std::size_t a = 0; a < 3; ++a) felt[a].turn = rows[channel][a];
  if (history.still[interval]) return felt;

  // A vector outside of an axis with direction d, seen from within, turns by -d x v per radian.
  // Along d itself, as the axis's own motion is, that is nothing.
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> directions(rows[0].data());
  const Eigen::Vector3d inner = directions.col(2), middle = directions.col(1);
  const double length_s = history.nodes[interval + 1].t_s - history.nodes[interval].t_s;
  // By the rates, as the turns that it is a column beside (TurnByRates): the errors of readings are
  // in the output alone.
  const Eigen::Vector3d whole_deg = 0.5 * length_s *
                                    (Eigen::Vector3d::Map(half.rate_deg_s.data()) +
                                     Eigen::Vector3d::Map(later.rate_deg_s.data()));
  const Eigen::Vector3d without_inner_deg = whole_deg - half.table_rate_deg_s[2] * length_s * inner;
  const auto row = static_cast<Eigen::Index>(channel);
  felt[2].direction = -kRadPerDeg * inner.cross(whole_deg)[row];
  felt[1].direction = -kRadPerDeg * middle.cross(without_inner_deg)[row];
  return felt;
}

}  // namespace gyrobench::calibration
