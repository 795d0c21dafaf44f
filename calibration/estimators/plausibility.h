// Results that cannot be: what is likelier wrong than the part.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/estimators/results.h"
#include "calibration/signal/collector.h"

namespace gyrobench::calibration {

// What is looked for in the columns of a measurement alone, so that every command names the same.
// Of no axis, and such that no result can be: an angle that is wrapped, turns that no reference
// saw, clocks that were not started together, an angle about an axis without a channel, a unit that
// changes.
std::vector<std::string> FaultsIn(const Recording& recording);
// Of an axis whose result is one that cannot be: a quaternion of another convention, axes that
// stand for each other, or the mistake that makes the factor between gyro and reference. Empty
// where they show none.
std::string CauseIn(const Recording& recording, SensorAxis axis);

// A sentence or two for each fault; where there is none, for each scale factor that is off by more
// than any MEMS gyro is, as far as a nominal sensitivity is known to compare with, and for each
// axis that turned while its output did not follow: what was found, the likeliest cause, what to
// check. Empty where all can be, and where the clocks were not started together: no other cause is
// to be looked for then.
struct Contradiction {
  std::array<bool, 3> axes = {};  // whose result cannot be
  std::string says;
};
std::vector<Contradiction> Contradictions(const AnalysisResult& result);
// Their sentences.
std::vector<std::string> Implausible(const AnalysisResult& result);
// Axes whose scale factor cannot be, or that turned and felt nothing.
std::vector<SensorAxis> ImplausibleAxes(const AnalysisResult& result);
// The same of one axis. `ratio`: true rate by the reference over the rate by the gyro's nominal
// sensitivity; NaN where one of them is not known. `inputs`: the measurements that it is of, at
// least one; where they differ in unit, sensitivity or gear, the causes that each allows are named,
// unless the data show one (`cause_in_data`, CauseIn) or their defects do. nullopt where it
// can be.
std::optional<std::string> ImplausibleScale(double ratio, SensorAxis axis,
                                            std::span<const MeasurementInfo* const> inputs,
                                            const std::string& cause_in_data = {},
                                            const std::vector<Defect>& defects = {});

}  // namespace gyrobench::calibration
