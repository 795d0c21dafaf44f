// Readings whose times are not known: a noise of the reference that grows with the rate.
#pragma once

#include <string>

namespace gyrobench::calibration {

struct Baseline;
struct CandidateSet;
class ChannelProblem;

// Stamps that a computer gives when it gets to a row are late by what else it does, each by another
// time. At 40 deg/s a millisecond is 0.04 deg: an error of the reading, beside which that of an
// encoder is nothing. Where the histories show such errors (StateHistory::timing_error_s), as much
// of it as the data want beside everything that may act becomes noise of the nodes. A sentence on
// it, empty where there is none.
std::string AddTimingNoise(const Baseline& baseline, const CandidateSet& candidates,
                           ChannelProblem* problem);

}  // namespace gyrobench::calibration
