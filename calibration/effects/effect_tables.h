// The parts of the catalogue. A new effect is one basis and one entry in one of them, and a test in
// tests/calibration/effects_test.cc.
#pragma once

#include <vector>

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

std::vector<Effect> RateEffects();
std::vector<Effect> AngleEffects();

}  // namespace gyrobench::calibration
