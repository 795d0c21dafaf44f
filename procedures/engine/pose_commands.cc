// Poses of the stand as scripts ask for them: "which angles point +x up", "what turns about z".

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"
#include "kinematics/find_pose.h"
#include "procedures/engine/command_call.h"

namespace gyrobench::procedures {
namespace {

using kinematics::StandAxis;

// What the stops and readings of a table scatter by, with some to spare.
constexpr double kSamePose_deg = 0.1;
constexpr StandAxis kAxes[] = {StandAxis::kOuter, StandAxis::kMiddle, StandAxis::kInner};

// "+x-y" as (1, -1, 0); nothing where the text is no direction.
std::optional<Vector3> Direction(const std::string& text) {
  Vector3 direction = {};
  std::size_t at = 0;
  while (at < text.size()) {
    const bool sign = text[at] == '+' || text[at] == '-';
    if (!sign && at > 0) return std::nullopt;
    const double side = text[at] == '-' ? -1.0 : 1.0;
    if (sign) ++at;
    const std::size_t axis =
        at < text.size() ? std::string("xyz").find(text[at]) : std::string::npos;
    if (axis == std::string::npos || direction[axis] != 0.0) return std::nullopt;
    direction[axis] = side;
    ++at;
  }
  if (text.empty()) return std::nullopt;
  return direction;
}

std::optional<Vector3> ReadDirection(const TableReader& fields, const char* field) {
  const auto text = fields.Text(field);
  if (!text) return std::nullopt;
  const auto direction = Direction(*text);
  if (!direction) {
    fields.Refuse(fmt::format(
        "{} = \"{}\": expected a direction of the sensor, as \"+z\", \"-x\" or \"+x-y\"", field,
        *text));
  }
  return direction;
}

// Fields of a table that asks for a pose.
const std::vector<std::string>& PoseFields() {
  static const std::vector<std::string> fields = {"up", "forward", "about", "axis"};
  return fields;
}

// Directions are texts: "z" and "+z" are the sensor's z axis, "-x+y" lies between -x and +y. Throws
// Error that names field, value and what was expected.
kinematics::PoseRequest ReadPoseRequest(const TableReader& fields) {
  kinematics::PoseRequest request;
  request.up = ReadDirection(fields, "up");
  request.forward = ReadDirection(fields, "forward");
  request.about = ReadDirection(fields, "about");
  const auto name = fields.Text("axis");
  if (!name) return request;
  const auto* const axis = std::find_if(std::begin(kAxes), std::end(kAxes),
                                        [&](StandAxis a) { return *name == Name(a); });
  if (axis == std::end(kAxes))
    fields.Refuse(fmt::format("axis = \"{}\": expected outer, middle or inner", *name));
  request.axis = *axis;
  return request;
}

// On the bench as it stands. Throws Error where the request contradicts itself or an angle is not
// known.
kinematics::PoseAnswer PoseOn(const Bench& bench, const kinematics::PoseRequest& request) {
  std::array<kinematics::AxisRange, 3> ranges = {};
  for (const AxisFacts& facts : bench.Axes()) {
    for (const StandAxis axis : kAxes) {
      if (facts.name == Name(axis))
        ranges[static_cast<std::size_t>(axis)] = {true, facts.angle_deg, facts.min_deg,
                                                  facts.max_deg};
    }
  }
  return kinematics::FindPose(bench.Geometry(), ranges, request);
}

// Turns one axis after the other, from the outer inwards, each at `rate_deg_s` or the axis's own
// limit, whichever is less; 0: at half of that limit. Axes within 0.1 deg of their angle stay.
void TurnTo(Bench& bench, const kinematics::Pose& pose, double rate_deg_s) {
  for (const AxisFacts& facts : bench.Axes()) {
    const auto* const axis = std::find_if(std::begin(kAxes), std::end(kAxes),
                                          [&](StandAxis a) { return facts.name == Name(a); });
    if (axis == std::end(kAxes)) continue;
    const double way_deg = pose.angles_deg[static_cast<std::size_t>(*axis)] - facts.angle_deg;
    if (std::abs(way_deg) < kSamePose_deg) continue;
    const double rate =
        rate_deg_s > 0.0 ? std::min(rate_deg_s, facts.max_rate_deg_s) : 0.5 * facts.max_rate_deg_s;
    bench.SafePoint();
    bench.Turn({facts.name, way_deg, rate, 0.5 * facts.max_acceleration_deg_s2});
  }
}

// The table that scripts get: what was found, or why nothing was.
int PushPose(const Call& call, const kinematics::PoseAnswer& answer) {
  lua_State* state = call.state;
  lua_createtable(state, 0, 7);
  lua_pushboolean(state, answer.pose ? 1 : 0);
  lua_setfield(state, -2, "possible");
  SetField(state, "reason", answer.reason);
  if (!answer.pose) return 1;
  const kinematics::Pose& pose = *answer.pose;
  lua_newtable(state);
  for (const AxisFacts& axis : call.bench.Axes()) {
    for (const std::size_t i : {0U, 1U, 2U}) {
      if (axis.name == Name(static_cast<kinematics::StandAxis>(i)))
        SetField(state, axis.name.c_str(), pose.angles_deg[i]);
    }
  }
  lua_setfield(state, -2, "angles_deg");
  if (pose.axis) SetField(state, "axis", std::string(Name(*pose.axis)));
  if (pose.axis) SetField(state, "sense", pose.sense);
  SetField(state, "off_deg", pose.off_deg);
  lua_pushboolean(state, pose.gimbal_lock ? 1 : 0);
  lua_setfield(state, -2, "gimbal_lock");
  return 1;
}

}  // namespace

int FindPose(const Call& call) {
  return PushPose(call, PoseOn(call.bench, ReadPoseRequest(call.Fields(PoseFields()))));
}

int TakePose(const Call& call) {
  std::vector<std::string> known = PoseFields();
  known.emplace_back("rate_deg_s");
  const TableReader fields = call.Fields(known);
  const double rate_deg_s = fields.Number("rate_deg_s").value_or(0.0);
  if (fields.Has("rate_deg_s") && !(rate_deg_s > 0.0))
    fields.Refuse(fmt::format("rate_deg_s = {:.10g}: expected a number above 0", rate_deg_s));
  const kinematics::PoseAnswer answer = PoseOn(call.bench, ReadPoseRequest(fields));
  if (!answer.pose)
    throw LimitError(fmt::format("{}: there is no such pose: {}", call.name, answer.reason));
  TurnTo(call.bench, *answer.pose, rate_deg_s);
  return PushPose(call, answer);
}

}  // namespace gyrobench::procedures
