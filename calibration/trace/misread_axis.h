// An axis of the stand that the reference reads wrong by a function of the axis's angle, as one
// whose disc or worm is off centre. Motions of the axes outside of it come from another direction
// than the readings say: all channels of the sensor feel that, and one that always feels it at the
// same angle takes it for a cross-axis part.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

struct Candidate;
struct ChannelFit;
struct ChannelRequest;
class ChannelProblem;
struct BenchFinding;
struct TracedChannel;

struct MisreadAxis {
  const Effect* effect = nullptr;
  BasisContext context;        // its table_axis: which one
  Eigen::VectorXd values;      // of the effect's terms
  Eigen::MatrixXd covariance;  // of these, as it is stated

  bool Is(const BenchFinding& found) const;
  bool SameAs(const MisreadAxis& other) const {
    return effect == other.effect && context.table_axis == other.context.table_axis &&
           context.nonlinear == other.context.nonlinear;
  }
};

// What a channel says of axes that it feels turn, of all terms of which its data tell.
std::vector<MisreadAxis> MisreadAxesOf(const ChannelProblem& problem,
                                       const std::vector<Candidate>& members,
                                       const ChannelFit& fit);

// What others of `traced` say of axes that the channel `k` says nothing of, and would see beyond
// its noise; of one that several speak of, what knows it best. `requests` in the same order. What
// is not larger than its own error is left out: it would do more harm than good at angles that its
// channel did not turn through.
std::vector<MisreadAxis> MisreadByOthers(std::span<const ChannelRequest> requests,
                                         std::span<const TracedChannel> traced, std::size_t k);

bool AreTheSame(std::span<const MisreadAxis> some, std::span<const MisreadAxis> others);

}  // namespace gyrobench::calibration
