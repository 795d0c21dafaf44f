// Stretches at rest in pieces: many short intervals of them say no more than few long ones.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "calibration/gls/interval_gls.h"

namespace gyrobench::calibration {

// Appends the pieces, of at most `piece_s` at rest, and each moving interval as it is. Of each
// interval: index of the one that it has become a part of.
std::vector<Eigen::Index> InPieces(std::span<const Interval> intervals, double piece_s,
                                   std::vector<Interval>* pieces);

}  // namespace gyrobench::calibration
