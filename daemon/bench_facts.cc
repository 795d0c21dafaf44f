#include "daemon/bench_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

#include "calibration/plan/next_manoeuvre.h"
#include "kinematics/find_pose.h"

namespace gyrobench::daemon {
namespace {

std::optional<std::size_t> IndexOf(const std::string& axis) {
  for (const std::size_t i : {0U, 1U, 2U}) {
    if (axis == kinematics::Name(static_cast<kinematics::StandAxis>(i))) return i;
  }
  return std::nullopt;
}

calibration::Manoeuvre ToManoeuvre(const procedures::Rehearsal& rehearsal) {
  calibration::Manoeuvre out;
  out.name = rehearsal.name;
  out.duration_s = rehearsal.duration_s;
  out.affordable = rehearsal.affordable;
  out.warms_degC = rehearsal.warms_degC;
  for (const procedures::AxisFacts& axis : rehearsal.axes) {
    if (const auto index = IndexOf(axis.name)) out.begin_deg[*index] = axis.angle_deg;
  }
  for (const procedures::PlannedMove& move : rehearsal.moves) {
    const auto index = IndexOf(move.axis);
    if (!index) continue;
    out.moves.push_back({static_cast<StandAxis>(*index), move.begin_s, move.from_deg, move.to_deg,
                         move.rate_deg_s, move.acceleration_deg_s2});
  }
  return out;
}

bool GaveNoAnswer(const DeviceFailure& failure) {
  return failure.code_kind == DeviceFailure::CodeKind::kSystemError ||
         failure.code_kind == DeviceFailure::CodeKind::kBadReply;
}

}  // namespace

const config::AxisConfig& ConfigOf(const config::StandConfig& stand, const std::string& name) {
  for (const config::AxisConfig& axis : stand.axes) {
    if (axis.name == name) return axis;
  }
  throw LimitError(fmt::format("this stand has no axis '{}'", name));
}

procedures::Choice ChooseAmong(const std::vector<procedures::Rehearsal>& menu, double small_below,
                               const calibration::Recording& so_far,
                               const calibration::Traced& traced, calibration::LoopMemory& memory) {
  std::vector<calibration::Manoeuvre> manoeuvres;
  for (const procedures::Rehearsal& rehearsal : menu) manoeuvres.push_back(ToManoeuvre(rehearsal));
  // The same for all of a menu, as a rule; the longest counts.
  memory.left_min = 0.0;
  for (const procedures::Rehearsal& rehearsal : menu)
    memory.left_min = std::max(memory.left_min, rehearsal.at_most_s / 60.0);
  const calibration::NextManoeuvre next =
      ChooseManoeuvre(so_far, traced, manoeuvres, memory, small_below);
  procedures::Choice choice;
  choice.settled = next.settled;
  choice.open = next.open;
  choice.never = next.never;
  choice.newly_closed = next.newly_closed;
  choice.small = next.small;
  choice.small_pairs = next.small_pairs;
  choice.best = next.best;
  if (next.best) {
    choice.because = next.worths[*next.best].because;
    choice.nats = next.worths[*next.best].nats;
  }
  return choice;
}

std::vector<std::string> HowItIs(const Acquisition& acquisition) {
  std::map<std::string, DeviceStatus> devices;
  for (const DeviceStatus& device : acquisition.Devices()) devices[device.name] = device;
  std::vector<std::string> lines;
  for (const LastSamples::Axis& axis : acquisition.Last().axes) {
    const AxisView view = acquisition.Axis(axis.name);
    std::string where = fmt::format("at {:.3f} deg", view.reference.angle_deg);
    if (!devices["encoder." + axis.name].ok) {
      where = fmt::format("last read at {:.3f} deg, its reference does not answer",
                          view.reference.angle_deg);
    }
    std::string motion = view.drive.moving ? "moving" : "at rest";
    if (const DeviceStatus& drive = devices["axis." + axis.name]; !drive.ok) {
      motion = GaveNoAnswer(drive.failure) ? "nobody knows whether it moves: no word of its drive"
                                           : "its drive answers, and is not as it has to be";
    }
    lines.push_back(fmt::format("axis.{}: {}, {}", axis.name, where, motion));
  }
  if (acquisition.outputs() == nullptr) return lines;
  for (const auto& [output, on] : acquisition.outputs()->States()) {
    lines.push_back(fmt::format("{}: {}", output,
                                !on   ? "nobody knows whether it is on"
                                : *on ? "on"
                                      : "off"));
  }
  return lines;
}

}  // namespace gyrobench::daemon
