// A gyro that is sampled seldom for its motion: how far it turned between samples.
#pragma once

#include <memory>
#include <string>

namespace gyrobench::calibration {

struct Baseline;
struct CandidateSet;
class ChannelProblem;

// What the samples of a gyro are: rates of single moments, means from half way to half way between
// their times, or means over the interval before their times.
enum class SamplesAre { kMoments, kMeans, kMeansBefore };

// Of samples that are rates of single moments, a rate that goes straight on either side of a corner
// says where between two of them that is; of means the sum says how far it turned (AsMeans). That
// means over the interval before are late by half of it stays in the output. The channels of a
// sensor are sampled alike, so the one that sees most of it says for all what the samples are.
//
// How much of the correction for moments the data ask for, as a filter takes from it, is estimated
// beside everything that may act; that for means is added whole. What the corners leave open then,
// as where the motion is not straight, is noise of their rows: of the turn up to a node, which the
// next row takes back, and of that from row to row, each as much as the restricted likelihood
// wants. Nothing is done where all that is little beside the angle random walk.
class SamplingMend {
 public:
  // Of a channel. What is given must outlive this.
  SamplingMend(const Baseline& baseline, const CandidateSet& candidates, ChannelProblem* problem);
  SamplingMend(SamplingMend&&) noexcept;
  ~SamplingMend();

  // How much of what samples are the channel sees: Corners::energy.
  double energy() const;
  // What the samples are by this channel's data: how much of each correction they ask for beside
  // everything that may act, and how clearly.
  SamplesAre Look();
  // Corrects output and noise of the problem. A sentence on what was done, empty where that is less
  // than the noise of these rows.
  std::string Mend(SamplesAre samples);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace gyrobench::calibration
