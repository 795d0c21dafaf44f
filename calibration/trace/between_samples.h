// A gyro that is sampled seldom for its motion: how far it turned between samples.
#pragma once

#include <string>

namespace gyrobench::calibration {

struct Baseline;
struct CandidateSet;
class ChannelProblem;

// Of samples that are rates of single moments, a rate that goes straight on either side of a corner
// says where between two of them that is; of samples that are means about their times, or over the
// interval before them, the sum says how far it turned (AsMeans). That the latter are late by half
// of that interval stays in the output. Which of them they are, and how much of that correction the
// data ask for, as a filter takes from it, is estimated beside everything that may act; it is added
// to the output. What the corners leave open then, as where the motion is not straight, is noise of
// their rows: of the turn up to a node, which the next row takes back, and of that from row to row,
// each as much as the restricted likelihood wants. Nothing is done where all that is little beside
// the angle random walk.
//
// A sentence on what was done, empty where that is less than the noise of these rows.
std::string MendBetweenSamples(const Baseline& baseline, const CandidateSet& candidates,
                               ChannelProblem* problem);

}  // namespace gyrobench::calibration
