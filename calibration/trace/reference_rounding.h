// What the steps of the reference's encoder make beside a motion that is made again and again.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "calibration/gls/noise_model.h"

namespace gyrobench::calibration {

struct Baseline;
class ChannelProblem;
class Selection;

// Of each row a number from 0, for GainWhereClustered. Rounding is a function of the angle, and errs
// by the same each time that a motion is made again from the same place: rows in which the axis
// turns have one number where its encoder is within some of its steps, whatever turn and measurement
// they are of. Other rows have numbers of their own.
std::vector<std::size_t> PlacesOfEncoder(const ChannelProblem& problem, std::size_t axis);

// The noise by a model of everything that may act, which takes in a part of what rounding makes, is
// too small. Where nothing was chosen and rounding alone is left, the noise beside the baseline, as
// searched from `noise`; nullopt where it is not so.
std::optional<NoiseModel> NoiseWithRounding(const ChannelProblem& problem, const Baseline& baseline,
                                            const Selection& selection, const NoiseModel& noise);

}  // namespace gyrobench::calibration
