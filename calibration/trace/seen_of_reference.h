// What a channel's effects say of the reference about the channel's axis, for all channels: each
// feels that axis by its cross-axis part, and they share the clock.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

struct Candidate;
struct ChannelFit;
struct ChannelRequest;
class ChannelProblem;
struct TracedChannel;

struct SeenOfReference {
  // By history and interval: by how much more the sensor turned about the axis than the reference
  // says [deg]; 0 where the channel does not say.
  std::vector<std::vector<double>> more_deg;
  std::vector<Delay> delays;     // among what is named
  std::vector<std::string> ids;  // of what is named
};
// By sensor axis; nullptr: nothing is seen of the reference about it.
using SeenOfAxes = std::array<std::shared_ptr<const SeenOfReference>, 3>;

// nullptr where the channel does not turn by itself, or names nothing that acts on its angle.
std::shared_ptr<const SeenOfReference> WhatIsSeenOfReference(const ChannelProblem& problem,
                                                             const std::vector<Candidate>& members,
                                                             const ChannelFit& fit);

// Whether a channel that was traced as it was asked would see beyond its noise that `now` is
// another.
bool IsFelt(const ChannelRequest& request, const TracedChannel& traced, const SeenOfAxes& now);

}  // namespace gyrobench::calibration
