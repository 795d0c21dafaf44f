// What a channel shows of the reference's error about the channel's axis. All channels have a use
// for it: each feels that axis by its cross-axis part, and they share the clock and the filter.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

struct Candidate;
struct ChannelFit;
struct ChannelRequest;
class ChannelProblem;
struct StateHistory;
struct TracedChannel;

// An axis of the stand that the reference reads wrong all along, by a function of the axis's angle.
struct MisreadAxis {
  const Effect* effect = nullptr;
  BasisContext context;        // its table_axis: which
  Eigen::VectorXd values;      // of the effect's terms
  Eigen::MatrixXd covariance;  // of these

  bool SameAs(const MisreadAxis& other) const {
    return effect == other.effect && context.table_axis == other.context.table_axis;
  }
};

struct ReferenceAngleError {
  // By history and interval: by how much more the sensor turned about the axis than the reference
  // says, as the gyro's filter passes it [deg]; 0 where the channel was not used.
  std::vector<std::vector<double>> turn_beyond_deg;
  std::vector<Delay> delays;  // that are named
  std::vector<MisreadAxis> misread;
};
// By sensor axis; nullptr: the axis does not turn, or nothing is named that acts on its angle.
using ReferenceAngleErrors = std::array<std::shared_ptr<const ReferenceAngleError>, 3>;

// What the members of a channel's model that act on its angle make of each of its rows. nullptr
// where the reference does not turn about the channel's axis, or there is no such member. The lag
// of the gyro's own filter is one of them: the channels of a part have the same filter.
std::shared_ptr<const ReferenceAngleError> ReferenceAngleErrorOf(
    const ChannelProblem& problem, const std::vector<Candidate>& members, const ChannelFit& fit);

// What other channels found of axes that are read wrong and this one did not: of each the one that
// knows it best. The motions of axes outside of such an axis come from another direction than the
// readings say, which a channel takes for a cross-axis part where the axis stands still meanwhile.
std::vector<MisreadAxis> MisreadByOthers(const ReferenceAngleErrors& errors, std::size_t channel);

// Whether the channel, traced without, would see that motions come from another direction, at the
// most: by the angle random walk alone.
bool MistakesDirection(const ChannelRequest& request, const TracedChannel& traced,
                       const std::vector<MisreadAxis>& misread);

// Whether the channel would see beyond its noise that `now` differs from what it was traced with.
bool NeedsRetrace(const ChannelRequest& request, const TracedChannel& traced,
                  const ReferenceAngleErrors& now);

// The longest that the delays add up to in the measurements, either way [s].
double LongestDelay_s(std::span<const StateHistory> histories, const std::vector<Delay>& delays);
// The same of the difference of two sums.
double DelaysApart_s(std::span<const StateHistory> histories, const std::vector<Delay>& a,
                     const std::vector<Delay>& b);

}  // namespace gyrobench::calibration
