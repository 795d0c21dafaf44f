#include "procedures/engine/poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrobench::procedures {
namespace {

using kinematics::StandAxis;
using kinematics::Vector3;

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

}  // namespace

const std::vector<std::string>& PoseFields() {
  static const std::vector<std::string> fields = {"up", "forward", "about", "axis"};
  return fields;
}

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

kinematics::PoseAnswer FindPose(const Bench& bench, const kinematics::PoseRequest& request) {
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

void TakePose(Bench& bench, const kinematics::Pose& pose, double rate_deg_s) {
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

}  // namespace gyrobench::procedures
