// The inverse problem of the stand: which angles point a sensor axis up, let the stand turn about
// it, or hold an orientation, within the limits of the axes that there are.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "kinematics/stand_frame.h"

namespace gyrobench::kinematics {

// Of the stand: index into angles.
enum class StandAxis { kOuter = 0, kMiddle = 1, kInner = 2 };
// "outer", "middle", "inner".
const char* Name(StandAxis axis);

// Where an axis stands and how far it goes [deg]. One that the stand does not have is fixed at 0.
struct AxisRange {
  bool present = false;
  double angle_deg = 0.0;
  double min_deg = 0.0;
  double max_deg = 0.0;
};

// Directions are in the sensor frame S and of any length but zero. At least `up` or `about` is
// given.
struct PoseRequest {
  std::optional<Vector3> up = {};       // is to point along W z
  std::optional<Vector3> forward = {};  // is to point along W x; needs `up`, square to it
  std::optional<Vector3> about = {};    // a stand axis is to lie along it, one way or the other
  std::optional<StandAxis> axis = {};   // that one; otherwise the one that needs the least motion
  // How far from its direction each of these may end [deg].
  double tolerance_deg = 0.5;
};

struct Pose {
  Vector3 angles_deg = {};  // of the stand; axes that need not move stay
  // With `about`: the axis that turns about it, and whether its positive sense is the sensor's (+1)
  // or the opposite (-1).
  std::optional<StandAxis> axis = {};
  double sense = 1.0;
  double off_deg = 0.0;  // the largest angle between a direction asked for and the one reached
  // Outer and inner axis are parallel here: the stand turns about two directions only.
  bool gimbal_lock = false;
};

// Either a pose, or why there is none: "axis.middle would stand at 180 deg, beyond its limits
// -80 .. 90 deg".
struct PoseAnswer {
  std::optional<Pose> pose;
  std::string reason;
};

// Ranges in the order outer, middle, inner. Of several poses the one with the least motion is
// taken. Throws Error where the request contradicts itself or anything is not a number.
PoseAnswer FindPose(const StandGeometry& geometry, const std::array<AxisRange, 3>& axes,
                    const PoseRequest& request);

}  // namespace gyrobench::kinematics
