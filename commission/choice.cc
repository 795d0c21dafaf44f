#include "commission/choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "base/error.h"

namespace gyrobench::commission {
namespace {

// Better than one reversed drive by nothing, worse than two: as likely as a mistake and a half.
constexpr double kCostOfMounting = 1.5;
// Of an accelerometer at rest that may be some percent off.
constexpr double kLeastForce_g = 0.7, kLargestForce_g = 1.4;
// Of all that fit; beyond, none does.
constexpr double kFits_deg = 6.0, kSameCost = 0.01;

std::size_t StandAxis(const std::string& name) {
  return name == "outer" ? 0 : (name == "middle" ? 1 : 2);
}

// Of a permutation: how many pairs are to be exchanged.
std::size_t Exchanges(const std::vector<std::size_t>& places) {
  std::vector<bool> seen(places.size(), false);
  std::size_t cycles = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (seen[i]) continue;
    ++cycles;
    for (std::size_t j = i; !seen[j]; j = places[j]) seen[j] = true;
  }
  return places.size() - cycles;
}

// The axes of the encoders that follow one.
std::vector<std::size_t> Places(const Seen& seen, const Assignment& wired) {
  std::vector<std::size_t> places;
  for (std::size_t j = 0; j < seen.encoders.size(); ++j)
    if (const auto axis = AxisOfEncoder(seen, wired, j)) places.push_back(*axis);
  return places;
}

double Cost(const config::StandConfig& stand, const Seen& seen, const Assignment& wired) {
  double cost = static_cast<double>(Exchanges(wired.axis_of_drive));
  for (const int sense : wired.sense_of_drive) cost += sense < 0 ? 1.0 : 0.0;
  for (std::size_t j = 0; j < seen.encoders.size(); ++j)
    cost += CountsBackwards(stand, seen, wired, j) ? 1.0 : 0.0;
  if (EachFollowsItsOwn(seen, wired)) cost += static_cast<double>(Exchanges(Places(seen, wired)));
  return cost + (wired.mounting_off_deg > kMountingKnown_deg ? kCostOfMounting : 0.0);
}

// `up`: see Felt.
Choice ChooseWith(const config::StandConfig& stand, const Seen& seen, const Vector3& up) {
  std::vector<std::size_t> stand_axes;
  std::vector<double> scales;
  for (const config::AxisConfig& axis : stand.axes) stand_axes.push_back(StandAxis(axis.name));
  for (const DriveSeen& drive : seen.drives) scales.push_back(drive.scale);
  std::vector<Assignment> fitting =
      FittingAssignments(stand.geometry, stand_axes, {seen.with_direction, up}, scales);
  const auto cost = [&](const Assignment& one) { return Cost(stand, seen, one); };
  std::ranges::stable_sort(
      fitting, {}, [&](const Assignment& one) { return std::pair(cost(one), one.misfit_deg); });
  Choice choice{fitting.front(), {}};
  for (std::size_t i = 1; i < fitting.size(); ++i)
    if (cost(fitting[i]) < cost(choice.wired) + kSameCost) choice.rivals.push_back(fitting[i]);
  return choice;
}

}  // namespace

std::optional<std::size_t> AxisOfEncoder(const Seen& seen, const Assignment& wired,
                                         std::size_t encoder) {
  const std::optional<std::size_t> drive = seen.encoders[encoder].drive;
  return drive ? std::optional(wired.axis_of_drive[*drive]) : std::nullopt;
}

bool CountsBackwards(const config::StandConfig& stand, const Seen& seen, const Assignment& wired,
                     std::size_t encoder) {
  const EncoderSeen& here = seen.encoders[encoder];
  return here.drive &&
         here.ratio * wired.sense_of_drive[*here.drive] * stand.axes[encoder].encoder.sign < 0.0;
}

bool EachFollowsItsOwn(const Seen& seen, const Assignment& wired) {
  std::vector<std::size_t> places = Places(seen, wired);
  std::ranges::sort(places);
  return places.size() == seen.encoders.size() &&
         std::ranges::adjacent_find(places) == places.end();
}

Choice Choose(const config::StandConfig& stand, const Measurements& measured, const Seen& seen) {
  const double force_g = Length(measured.specific_force_g);
  const bool has_up = force_g > kLeastForce_g && force_g < kLargestForce_g;
  Choice choice = ChooseWith(stand, seen, has_up ? measured.specific_force_g : Vector3{});
  if (has_up && choice.wired.misfit_deg > kFits_deg) choice = ChooseWith(stand, seen, {});
  if (choice.wired.misfit_deg <= kFits_deg) return choice;
  throw DataError(fmt::format(
      "the directions in which the gyro feels the axes are {:.0f} deg off those of any stand of "
      "this "
      "kind: are the axes at their marks, and outer_middle_deg and middle_inner_deg right?",
      choice.wired.misfit_deg));
}

}  // namespace gyrobench::commission
