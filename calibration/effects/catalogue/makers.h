// The list of effects: one function each, in a file of its own in this folder. A new effect is that
// file, its line here, and a test in tests/calibration/effects_test.cc.
#pragma once

#include "calibration/effects/effect.h"

// In the order in which they are listed, and tried.
#define GYROBENCH_EFFECTS(X)  \
  X(BiasGLinear)              \
  X(BiasGSquared)             \
  X(ScaleG)                   \
  X(ScaleTemperature)         \
  X(ScaleQuadraticOdd)        \
  X(ScaleCubic)               \
  X(ScaleQuadraticEven)       \
  X(ScaleAsymmetry)           \
  X(BiasTemperatureRate)      \
  X(BiasHysteresis)           \
  X(BiasWarmUp)               \
  X(BiasVibration)            \
  X(BiasVibrationAtResonance) \
  X(BiasOf)                   \
  X(ScaleOf)                  \
  X(BiasEarthRate)            \
  X(BiasStep)                 \
  X(BiasTone)                 \
  X(AngleLatency)             \
  X(AngleLatencyOfRun)        \
  X(BandwidthFirstOrder)      \
  X(AngleClockDrift)          \
  X(AngleWormPeriod)          \
  X(AngleEccentricity1)       \
  X(AngleEccentricity2)       \
  X(AngleBacklash)            \
  X(AngleRipple)              \
  X(AngleStep)

namespace gyrobench::calibration {

#define GYROBENCH_DECLARE(name) Effect name();
GYROBENCH_EFFECTS(GYROBENCH_DECLARE)
#undef GYROBENCH_DECLARE

}  // namespace gyrobench::calibration
