// Noises of some rows beside those of gyro and reference: of readings whose times are not known,
// and of a last digit that is coarser than the noise.
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

// What rounding makes of the mean at a steady rate (OutputRounding) is another from rate to rate:
// it passes for a nonlinearity, or for a resonance at the one speed that it is largest at. As much
// of it as the data want beside everything that may act becomes noise: a jump of the bias from one
// steady rate to the next. A sentence on it, empty where there is none.
std::string AddRoundingNoise(const Baseline& baseline, const CandidateSet& candidates,
                             ChannelProblem* problem);

}  // namespace gyrobench::calibration
