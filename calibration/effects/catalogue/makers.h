// One function an effect. A new effect is one file here with one line in this list, one in
// catalogue.cc, and a test in tests/calibration/effects_test.cc.
#pragma once

#include "calibration/effects/effect.h"

namespace gyrobench::calibration {

Effect BiasGLinear();
Effect BiasGSquared();
Effect ScaleG();
Effect ScaleTemperature();
Effect ScaleQuadraticOdd();
Effect ScaleCubic();
Effect ScaleQuadraticEven();
Effect ScaleAsymmetry();
Effect BiasTemperatureRate();
Effect BiasHysteresis();
Effect BiasWarmUp();
Effect BiasVibration();
Effect BiasVibrationAtResonance();
Effect BiasOf();
Effect ScaleOf();
Effect BiasEarthRate();
Effect BiasStep();
Effect BiasTone();
Effect AngleLatency();
Effect BandwidthFirstOrder();
Effect AngleClockDrift();
Effect AngleWormPeriod();
Effect AngleEccentricity1();
Effect AngleEccentricity2();
Effect AngleBacklash();
Effect AngleRipple();
Effect AngleStep();

}  // namespace gyrobench::calibration
