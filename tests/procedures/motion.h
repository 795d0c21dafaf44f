// What a procedure has shown to the sensor, by the geometry of the stand.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "kinematics/stand_frame.h"
#include "procedures/engine/dry_bench.h"
#include "tests/procedures/fake_bench.h"

namespace gyrobench::procedures {

inline std::size_t IndexOf(const std::string& axis) {
  return axis == "outer" ? 0U : axis == "middle" ? 1U : 2U;
}

inline std::vector<AxisFacts> AxesNamed(const std::vector<std::string>& names) {
  std::vector<AxisFacts> axes;
  for (const AxisFacts& axis : ThreeAxes()) {
    for (const std::string& name : names) {
      if (axis.name == name) axes.push_back(axis);
    }
  }
  return axes;
}

// Keeps what the sensor feels: up (in S) at each rest, rates (in S) of each turn.
class FeltBench : public FakeBench {
 public:
  explicit FeltBench(std::vector<AxisFacts> of = ThreeAxes()) { axes = std::move(of); }

  struct Turned {
    Vector3 rate_deg_s = {};  // at the begin
    Vector3 up = {};
    double angle_deg = 0.0;
  };
  std::vector<Vector3> rests;  // up
  std::vector<double> rest_s;
  std::vector<Turned> turned;

  Vector3 Up() const { return kinematics::StandFrame(geometry).Orientation(Angles())[2]; }

  TurnOutcome Turn(const TurnCommand& command) override {
    const Matrix3 j = kinematics::StandFrame(geometry).Rates(Angles());
    const double rate = std::copysign(command.rate_deg_s, command.angle_deg);
    const std::size_t axis = IndexOf(command.axis);
    turned.push_back(
        {{j[0][axis] * rate, j[1][axis] * rate, j[2][axis] * rate}, Up(), command.angle_deg});
    return FakeBench::Turn(command);
  }
  void Rest(double duration_s) override {
    rests.push_back(Up());
    rest_s.push_back(duration_s);
    FakeBench::Rest(duration_s);
  }

 private:
  Vector3 Angles() const {
    Vector3 angles_deg = {};
    for (const AxisFacts& axis : axes) angles_deg[IndexOf(axis.name)] = axis.angle_deg;
    return angles_deg;
  }
};

inline double Dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

}  // namespace gyrobench::procedures
