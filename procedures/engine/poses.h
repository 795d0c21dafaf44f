// Poses of the stand as scripts ask for them: "which angles point +x up", "what turns about z".
#pragma once

#include <string>
#include <vector>

#include "kinematics/find_pose.h"
#include "procedures/engine/bench.h"
#include "procedures/engine/table_reader.h"

namespace gyrobench::procedures {

// Fields of a table that asks for a pose: up, forward, about, axis.
const std::vector<std::string>& PoseFields();

// Directions are texts: "z" and "+z" are the sensor's z axis, "-x+y" lies between -x and +y. Throws
// Error that names field, value and what was expected.
kinematics::PoseRequest ReadPoseRequest(const TableReader& fields);

// On the bench as it stands. Throws Error where the request contradicts itself or an angle is not
// known.
kinematics::PoseAnswer FindPose(const Bench& bench, const kinematics::PoseRequest& request);

// Turns one axis after the other, from the outer inwards, each at `rate_deg_s` or the axis's own
// limit, whichever is less; 0: at half of that limit. Axes within 0.1 deg of their angle stay.
void TakePose(Bench& bench, const kinematics::Pose& pose, double rate_deg_s);

}  // namespace gyrobench::procedures
