// Earth's rotation where the site's latitude is not known: what it may be taken for, and what is
// said of it.
#pragma once

#include <string>
#include <vector>

#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

// Makes bias.earth_rate a rival of a plain g-sensitivity that is not certainly larger than Earth's
// rotation: its vertical part is one with k_z of a sensor axis z, so no odds can tell.
// For measurements without latitude or orientation only.
void AddEarthAsRival(TracedEffect* effect);

// What a reader is to do where Earth's rotation is among the effects or their rivals; empty where
// it is not.
std::string LatitudeNeeded(const std::vector<TracedEffect>& effects);

}  // namespace gyrobench::calibration
