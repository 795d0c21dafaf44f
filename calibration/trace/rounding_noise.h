// A gyro's last digit that is coarser than its noise.
#pragma once

#include <string>

namespace gyrobench::calibration {

struct Baseline;
struct CandidateSet;
class ChannelProblem;

// What rounding makes of the mean at a steady rate (OutputRounding) is another from rate to rate:
// it passes for a nonlinearity, or for a resonance at the one speed that it is largest at. As much
// of it as the data want beside everything that may act becomes noise: a jump of the bias from one
// steady rate to the next. A sentence on it, empty where there is none.
std::string AddRoundingNoise(const Baseline& baseline, const CandidateSet& candidates,
                             ChannelProblem* problem);

}  // namespace gyrobench::calibration
