// Frames of sensor and world (docs/measurement-table.md): plain functions.
//
// World W: z up. R_WS rotates sensor-frame vectors into W. Right-handed, degrees throughout.
#pragma once

#include <array>

namespace gyrobench::kinematics {

using Vector3 = std::array<double, 3>;
using Matrix3 = std::array<Vector3, 3>;  // [row][column]

// Earth's rotation in W [deg/s]: 15.041 deg/h (cos lat cos h, -cos lat sin h, sin lat), h the
// heading of W's x axis from north.
Vector3 EarthRate(double latitude_deg, double heading_deg);

// R_WS of a unit quaternion (w, x, y, z).
Matrix3 QuaternionOrientation(const std::array<double, 4>& q_wxyz);

// Rotation vector, in the sensor frame [deg], of the shortest way from one orientation to the next:
//   q_next = q_from (x) exp(v / 2)
Vector3 RotationBetween(const std::array<double, 4>& from_wxyz,
                        const std::array<double, 4>& to_wxyz);

// M^T v: a vector given in W, expressed in S, for M = R_WS.
Vector3 TransposedTimes(const Matrix3& m, const Vector3& v);

}  // namespace gyrobench::kinematics
