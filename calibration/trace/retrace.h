// Whether a channel is traced again for what another one shows of the reference.
#pragma once

#include <memory>
#include <vector>

#include "calibration/trace/reference_angle_error.h"

namespace gyrobench::calibration {

struct Candidate;
struct ChannelFit;
struct ChannelRequest;
class ChannelProblem;
struct TracedChannel;

// What the members of a channel's model that act on its angle make of each of its rows. nullptr
// where the reference does not turn about the channel's axis, or there is no such member. The lag
// of the gyro's own filter is one of them: the channels of a part have the same filter.
std::shared_ptr<const ReferenceAngleError> ReferenceAngleErrorOf(
    const ChannelProblem& problem, const std::vector<Candidate>& members, const ChannelFit& fit);

// Whether the channel would see beyond its noise that `now` differs from what it was traced with.
bool NeedsRetrace(const ChannelRequest& request, const TracedChannel& traced,
                  const ReferenceAngleErrors& now);

}  // namespace gyrobench::calibration
