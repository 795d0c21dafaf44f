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

struct Sampling {
  SamplesAre samples = SamplesAre::kMoments;
  double late_s = 0.0;  // of means over the interval before: half of it, and what a bus adds
};

// What one channel says of it.
struct SamplingSeen {
  Sampling sampling;
  bool clear = false;      // whether its data tell
  double std_error = 0.0;  // of how much of the correction for means they ask for
};

// Of samples that are rates of single moments, a rate that goes straight on either side of a corner
// says where between two of them that is; of means the sum says how far it turned (AsMeans). That
// means over the interval before are late by half of it stays in the output.
//
// How much of the correction for moments the data ask for, as a filter takes from it, is estimated
// beside everything that may act; that for means is added whole. What the corners leave open then,
// as where the motion is not straight, is noise of their rows: of the turn up to a node, which the
// next row takes back, and of that from row to row, each as much as the restricted likelihood
// wants. Corners of moments that are little beside the angle random walk are left as they are.
class SamplingMend {
 public:
  // Of a channel. What is given must outlive this.
  SamplingMend(const Baseline& baseline, const CandidateSet& candidates, ChannelProblem* problem);
  ~SamplingMend();

  // Whether the channel may tell what the samples are, by how far moments and means are apart.
  bool MayTell() const;
  // How much of each correction its data ask for beside everything that may act, and how clearly.
  SamplingSeen Look() const;
  // Corrects output and noise of the problem. A sentence on what was done, empty where that is less
  // than the noise of these rows.
  std::string Mend(const Sampling& sampling);

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace gyrobench::calibration
