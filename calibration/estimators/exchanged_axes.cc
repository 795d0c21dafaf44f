#include "calibration/estimators/exchanged_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/signal/line_sums.h"
#include "calibration/signal/output_unit.h"

namespace gyrobench::calibration {
namespace {

// Which is far beyond any misalignment of a part that is mounted as declared.
constexpr double kFollowsMore = 5.0;
constexpr double kLeastShareExplained = 0.5;
constexpr double kFollowsItAlone = 0.9;  // share of the variance
// An axis that feels so much of a turn about another is not one that is merely misaligned.
constexpr double kMostOfIt = 0.5;
constexpr double kHardlyTurns = 0.05;

// Of each channel's mean rates on the reference's about `axis`, over the intervals in which the
// table turned about it more than about the others, or rested. `turned`: the reference's rates
// about the others in place of the output.
std::array<LineSums, 3> SumsOf(const Columns& columns, std::size_t axis, bool turned = false) {
  std::array<LineSums, 3> sums;
  for (std::size_t i = 1; i < columns.nodes.size(); ++i) {
    const Node& node = columns.nodes[i];
    const Node& before = columns.nodes[i - 1];
    const double span_s = node.at.t_s - before.at.t_s;
    Vector3 turned_deg = {};
    double most_deg = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      turned_deg[c] = node.rotation_deg[c] - before.rotation_deg[c];
      most_deg = std::fmax(most_deg, std::fabs(turned_deg[c]));
    }
    if (!(span_s > 0.0) || std::fabs(turned_deg[axis]) < most_deg) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double output = turned ? turned_deg[c] : node.at.z[c] - before.at.z[c];
      if (std::isfinite(output)) sums[c].Add(turned_deg[axis] / span_s, output / span_s);
    }
  }
  return sums;
}

}  // namespace

std::string FollowedByAnother(const Columns& columns, SensorAxis axis) {
  const auto own = static_cast<std::size_t>(axis);
  const std::array<LineSums, 3> sums = SumsOf(columns, own);
  // Misaligned axes feel a part of it too.
  std::size_t most = own;
  for (std::size_t c = 0; c < 3; ++c) {
    if (sums[c].Explained() > kLeastShareExplained &&
        !(std::fabs(sums[c].Slope()) <= std::fabs(sums[most].Slope())))
      most = c;
  }
  if (most == own || !(std::fabs(sums[most].Slope()) > kFollowsMore * std::fabs(sums[own].Slope())))
    return "";
  return fmt::format(
      "two axes of the gyro stand for each other: what the reference turns about {0} is followed "
      "by the output of {1} ({2:.3g} of its unit per deg/s) and not by that of {0} ({3:.2g}). "
      "Exchange the two columns (or registers of the device map), or declare the mounting "
      "(mount_x_deg, mount_y_deg, mount_z_deg)",
      "xyz"[own], "xyz"[most], sums[most].Slope(), sums[own].Slope());
}

std::string FollowedByAnotherAlone(const MeasurementInfo& info, const Columns& columns) {
  const double units = NominalUnitsPerDegPerS(info);
  if (!std::isfinite(units)) return "";
  for (std::size_t own = 0; own < 3; ++own) {
    if (info.gyro_present[own]) continue;
    const std::array<LineSums, 3> sums = SumsOf(columns, own);
    const std::array<LineSums, 3> turned = SumsOf(columns, own, true);
    for (std::size_t c = 0; c < 3; ++c) {
      // What turns about its own axis at the same time says nothing of another.
      if (!(std::fabs(turned[c].Slope()) < kHardlyTurns)) continue;
      const bool follows = info.gyro_present[c] && sums[c].Explained() > kFollowsItAlone &&
                           std::fabs(sums[c].Slope()) > kMostOfIt * units;
      if (!follows) continue;
      return fmt::format(
          "what the reference turns about {0} is followed by the output of gyro {1} ({2:.3g} deg/s "
          "per deg/s), and there is no gyro {0}: most likely the angle's column or the gyro's is "
          "named for another axis. Rename it, or declare the mounting (mount_x_deg, mount_y_deg, "
          "mount_z_deg)",
          "xyz"[own], "xyz"[c], sums[c].Slope() / units);
    }
  }
  return "";
}

std::optional<double> FollowedSensitivity(const Columns& columns, SensorAxis axis) {
  const auto own = static_cast<std::size_t>(axis);
  const LineSums sums = SumsOf(columns, own)[own];
  if (!(sums.Explained() > kFollowsItAlone)) return std::nullopt;
  return sums.Slope();
}

}  // namespace gyrobench::calibration
