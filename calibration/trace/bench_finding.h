// What one channel shows of the bench, for the others: an axis of the stand that is read wrong is
// so for all of them, and a stand that shakes at some speed does so with any of its axes.
#pragma once

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace gyrobench::calibration {

struct Candidate;
struct ChannelFit;
class ChannelProblem;
struct Effect;

// An effect of the catalogue on the angle of one axis, or one of the stand's vibration.
struct BenchFinding {
  const Effect* effect = nullptr;
  std::size_t table_axis = 2;  // StandAxis
  std::vector<double> nonlinear;
  std::optional<std::size_t> power_on;  // ChannelProblem::first_number of the one that it is of
  // Of its coefficients together, what they may err by included [their unit]: the same axis errs by
  // no more in any channel.
  double largest = std::numeric_limits<double>::infinity();
  bool of_stand = false;  // BasisContext
};

// What a channel says of the axes that it feels turn and of the stand; and the axes whose errors it
// feels.
struct BenchFindings {
  std::vector<BenchFinding> found;
  std::vector<std::size_t> turning;  // ChannelProblem::table_axes
  std::vector<std::size_t> felt;     // ChannelProblem::axes_with_felt_errors
  // Found by the channel's own rate; by that of all axes it may fit better, here and elsewhere.
  std::vector<BenchFinding> supposed = {};
};
BenchFindings FindingsOf(const ChannelProblem& problem, const std::vector<Candidate>& members,
                         const ChannelFit& fit);
// What a channel says of itself, without what it was told.
BenchFindings Without(BenchFindings own, const std::vector<BenchFinding>& told);
// Whether a channel names something of `before` that is not in `now`.
bool NamesWhatIsGone(const BenchFindings& named, const std::vector<BenchFinding>& before,
                     const std::vector<BenchFinding>& now);

// What all channels have found of the axes whose errors a channel feels, and that it has not looked
// for: errors of an axis that it feels by the direction of others' motions alone, which would
// describe many a thing that no channel sees in the axis itself; and what scans of other channels
// have found at places of their own. The axes of a stand are of one make: where one has a ripple,
// another that the channel feels turn may have as many periods a turn.
std::vector<BenchFinding> NewTo(const BenchFindings& own, const std::vector<BenchFinding>& found);

// Those of power-ons that the channel has.
std::vector<Candidate> CandidatesOf(const ChannelProblem& problem,
                                    std::span<const BenchFinding> errors);

}  // namespace gyrobench::calibration
