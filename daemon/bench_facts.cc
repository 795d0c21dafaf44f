#include "daemon/bench_facts.h"

#include <algorithm>
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

}  // namespace

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

}  // namespace gyrobench::daemon
