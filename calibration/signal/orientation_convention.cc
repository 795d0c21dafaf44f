// By which convention an orientation reference was written.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "base/geometry.h"
#include "calibration/signal/columns.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/line_sums.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

// Of the variance of all channels, what a convention may leave. A right one leaves what noise,
// misalignment and a lag make of a turn that begins within an interval.
constexpr double kMostLeft = 0.1;
// Of the mean square rate: an axis that turned by less says nothing of its channel.
constexpr double kLeastShare = 0.02;
// Below it nothing turned [deg].
constexpr double kLeastTurnedAtAll_deg = 30.0;
// Longer intervals say nothing of a rate that changes meanwhile.
constexpr double kLongest_s = 2.0;

struct Convention {
  // Which column holds w, x, y, z.
  std::array<std::size_t, 4> column;
  bool inverse;
  const char* says;
};
constexpr std::array<Convention, 5> kOthers = {{
    {{0, 1, 2, 3},
     true,
     "the inverse one: it rotates world-frame vectors into the sensor's frame. Change the sign of "
     "ref_qx, ref_qy and ref_qz"},
    {{3, 0, 1, 2},
     false,
     "in the order x, y, z, w: the column ref_qw holds x, and ref_qz the scalar part w. Name the "
     "four columns ref_qx, ref_qy, ref_qz, ref_qw"},
    {{1, 2, 3, 0},
     false,
     "in the order w, x, y, z, under columns that are named x, y, z, w: ref_qx holds the scalar "
     "part. Name the columns in the order of what they hold"},
    {{3, 0, 1, 2},
     true,
     "in the order x, y, z, w, and the inverse one: ref_qw holds x, ref_qz the scalar part w, and "
     "it rotates world-frame vectors into the sensor's frame. Name the four columns ref_qx, "
     "ref_qy, ref_qz, ref_qw, and change the sign of x, y and z"},
    {{1, 2, 3, 0},
     true,
     "in the order w, x, y, z, under columns that are named x, y, z, w, and the inverse one: "
     "ref_qx holds the scalar part, and it rotates world-frame vectors into the sensor's frame. "
     "Name the columns in the order of what they hold, and change the sign of x, y and z"},
}};
constexpr Convention kGiven = {{0, 1, 2, 3}, false, ""};

Vector3d ToEigen(const Vector3& v) { return {v[0], v[1], v[2]}; }

// As it was written, but for its sign.
Quaterniond Written(const Node& node) {
  Eigen::Matrix3d world;  // R_WS
  world.row(0) = ToEigen(node.world_x);
  world.row(2) = ToEigen(node.world_z);
  world.row(1) = world.row(2).cross(world.row(0));
  return Quaterniond(world).normalized();
}

Quaterniond By(const Convention& convention, const Quaterniond& written) {
  const std::array<double, 4> columns = {written.w(), written.x(), written.y(), written.z()};
  const auto part = [&](std::size_t i) { return columns[convention.column[i]]; };
  const Quaterniond q(part(0), part(1), part(2), part(3));
  return convention.inverse ? q.conjugate() : q;
}

// In the sensor's frame [deg].
Vector3d RotationFrom(const Quaterniond& from, const Quaterniond& to) {
  Quaterniond between = from.conjugate() * to;
  if (between.w() < 0.0) between.coeffs() = -between.coeffs();
  const double sine = between.vec().norm();
  if (!(sine > 0.0)) return Vector3d::Zero();
  return kDegPerRad * 2.0 * std::atan2(sine, between.w()) / sine * between.vec();
}

class Comparison {
 public:
  Comparison(const MeasurementInfo& info, const Columns& columns) : info_(info) {
    for (const Node& node : columns.nodes) {
      const bool known = std::isfinite(node.world_x[0]) && std::isfinite(node.world_z[0]);
      if (!known) continue;
      nodes_.push_back(&node);
      written_.push_back(Written(node));
    }
  }

  // Factor of the slopes by which it agrees: 1, or -1 of one that is of the other sense; nullopt
  // where it does not.
  std::optional<double> Agrees(const Convention& convention) const {
    std::array<LineSums, 3> lines;  // of each channel on its rate
    Vector3d square = Vector3d::Zero();
    double turned_deg = 0.0;
    for (std::size_t i = 1; i < nodes_.size(); ++i) {
      const double span_s = nodes_[i]->at.t_s - nodes_[i - 1]->at.t_s;
      if (!(span_s > 0.0) || span_s > kLongest_s) continue;
      const Vector3d turn =
          RotationFrom(By(convention, written_[i - 1]), By(convention, written_[i]));
      turned_deg += turn.norm();
      square += turn.cwiseAbs2() / span_s;
      for (std::size_t c = 0; c < 3; ++c)
        lines[c].Add(turn[static_cast<Eigen::Index>(c)] / span_s,
                     (nodes_[i]->at.z[c] - nodes_[i - 1]->at.z[c]) / span_s);
    }
    if (!(turned_deg > kLeastTurnedAtAll_deg)) return std::nullopt;
    return Judge(lines, square);
  }

 private:
  std::optional<double> Judge(const std::array<LineSums, 3>& lines, const Vector3d& square) const {
    double left = 0.0, all = 0.0;
    std::vector<double> slopes;
    for (std::size_t c = 0; c < 3; ++c) {
      if (!info_.gyro_present[c]) continue;
      const bool turned = square[static_cast<Eigen::Index>(c)] > kLeastShare * square.sum();
      left += turned ? lines[c].LeftOfY() : lines[c].SquareY();
      all += lines[c].SquareY();
      if (turned) slopes.push_back(lines[c].Slope());
    }
    if (slopes.empty() || !(left < kMostLeft * all)) return std::nullopt;
    const double nominal = NominalUnitsPerDegPerS(info_);
    const double expected = std::isfinite(nominal) ? nominal : std::fabs(slopes.front());
    const double sense = slopes.front() > 0.0 ? 1.0 : -1.0;
    const bool alike = std::ranges::all_of(slopes, [&](double slope) {
      return std::fabs(sense * slope / expected - 1.0) < kLargestScaleError;
    });
    return alike ? std::optional(sense) : std::nullopt;
  }

  const MeasurementInfo& info_;
  std::vector<const Node*> nodes_;
  std::vector<Quaterniond> written_;
};

}  // namespace

std::string OtherConvention(const MeasurementInfo& info, const Columns& columns) {
  if (info.reference != ReferenceKind::kOrientation) return "";
  const Comparison comparison(info, columns);
  const std::optional<double> given = comparison.Agrees(kGiven);
  if (given && *given > 0.0) return "";
  for (const Convention& other : kOthers) {
    const std::optional<double> sense = comparison.Agrees(other);
    if (!sense || *sense < 0.0) continue;
    // About one axis alone the two are the same.
    const char* const or_else =
        given ? "; or, where it is as declared, the axis that turns points the other way: check "
                "the mounting"
              : "";
    return fmt::format("the quaternion of the reference is {}{}", other.says, or_else);
  }
  return "";
}

}  // namespace gyrobench::calibration
