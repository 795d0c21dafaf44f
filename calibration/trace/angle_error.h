// What one channel shows of the readings of a stand's axis, for the others: the axis is read wrong
// for all of them.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "calibration/trace/candidate.h"
#include "calibration/trace/channel_fit.h"

namespace gyrobench::calibration {

// An effect of the catalogue on the angle of one axis.
struct AngleError {
  const Effect* effect = nullptr;
  std::size_t table_axis = 2;  // StandAxis
  std::vector<double> nonlinear;
  std::optional<std::size_t> power_on;  // ChannelProblem::first_number of the one that it is of
  // Of its coefficients together, what they may err by included [their unit]: the same axis errs by
  // no more in any channel.
  double largest = std::numeric_limits<double>::infinity();
};

// What a channel that feels an axis turn says of its readings; and the axes whose errors it feels.
struct AngleErrors {
  std::vector<AngleError> found;
  std::vector<std::size_t> turning;  // ChannelProblem::table_axes
  std::vector<std::size_t> felt;     // ChannelProblem::axes_with_felt_errors
};
AngleErrors AngleErrorsOf(const ChannelProblem& problem, const std::vector<Candidate>& members,
                          const ChannelFit& fit);
// What a channel says of itself, without what it was told.
AngleErrors Without(AngleErrors own, const std::vector<AngleError>& told);
// Whether a channel names something of `before` that is not in `now`.
bool NamesWhatIsGone(const AngleErrors& named, const std::vector<AngleError>& before,
                     const std::vector<AngleError>& now);

// What all channels have found of the axes whose errors a channel feels, and that it has not looked
// for: errors of an axis that it feels by the direction of others' motions alone, which would
// describe many a thing that no channel sees in the axis itself; and what scans of other channels
// have found at places of their own. The axes of a stand are of one make: where one has a ripple,
// another that the channel feels turn may have as many periods a turn.
std::vector<AngleError> NewTo(const AngleErrors& own, const std::vector<AngleError>& found);

// Those of power-ons that the channel has.
std::vector<Candidate> CandidatesOf(const ChannelProblem& problem,
                                    std::span<const AngleError> errors);

}  // namespace gyrobench::calibration
