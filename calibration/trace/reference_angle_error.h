// What a channel shows of the reference's error about the channel's axis. All channels have a use
// for it: each feels that axis by its cross-axis part, and they share the clock and the filter.
#pragma once

#include <array>
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

struct ReferenceAngleError {
  // By history and interval: by how much more the sensor turned about the axis than the reference
  // says, as the gyro's filter passes it [deg]; 0 where the channel was not used.
  std::vector<std::vector<double>> turn_beyond_deg;
  std::vector<Delay> delays;  // that are named
};
// By sensor axis; nullptr: the axis does not turn, or nothing is named that acts on its angle.
using ReferenceAngleErrors = std::array<std::shared_ptr<const ReferenceAngleError>, 3>;

// What the members of a channel's model that act on its angle make of each of its rows. nullptr
// where the reference does not turn about the channel's axis, or there is no such member. The lag
// of the gyro's own filter is one of them: the channels of a part have the same filter.
std::shared_ptr<const ReferenceAngleError> ReferenceAngleErrorOf(
    const ChannelProblem& problem, const std::vector<Candidate>& members, const ChannelFit& fit);

// Whether the channel would see beyond its noise that `now` differs from what it was traced with.
bool NeedsRetrace(const ChannelRequest& request, const TracedChannel& traced,
                  const ReferenceAngleErrors& now);

// What is left of the delays at a node whose readings are on the gyro's clock already; 0 without
// any delay.
double DelayLeft_s(const std::vector<Delay>& delays, const SensorState& node);
// The longest that the delays add up to in the measurements, either way [s]; and that is left.
double LongestDelay_s(std::span<const StateHistory> histories, const std::vector<Delay>& delays);
double LongestDelayLeft_s(std::span<const StateHistory> histories,
                          const std::vector<Delay>& delays);
// The same of the difference of two sums.
double DelaysApart_s(std::span<const StateHistory> histories, const std::vector<Delay>& a,
                     const std::vector<Delay>& b);

}  // namespace gyrobench::calibration
