// When a soak has settled, and how long it will still take.
#pragma once

#include <deque>

#include "procedures/engine/bench.h"

namespace gyrobench::procedures {

// What is expected of a gyro that was cooled, before its temperature is seen:
// T = end - kExpectedCold_degC exp(-t / kExpectedTimeConstant_s).
inline constexpr double kExpectedCold_degC = 40.0;
inline constexpr double kExpectedTimeConstant_s = 250.0;

// Duration of a soak that begins `begin_s` after the gyro was put on the stand, its temperature
// then going as above: it settles when the change within the window is below the drift asked for.
double ExpectedSoak_s(const SoakCommand& command, double begin_s,
                      double cold_degC = kExpectedCold_degC,
                      double time_constant_s = kExpectedTimeConstant_s);

// Judges the temperatures of a soak. A thermometer's noise is no drift: its peaks alone are beyond
// 0.1 degC, so that the change is that of a line through the window and of the means of its
// quarters, whichever is larger.
class Settling {
 public:
  // `begin_s` as above.
  Settling(const SoakCommand& command, double begin_s);

  // t_s since the begin of the soak, growing. A temperature that is NaN begins the window anew.
  void Add(double t_s, double temperature_degC);
  bool settled() const;
  // Change within the window [degC]; NaN until it is full.
  double change_degC() const { return change_degC_; }
  // Until the soak ends, settled or at its max_s: by the decay that was seen, before that by what
  // is expected.
  double remaining_s() const;

 private:
  struct Reading {
    double t_s = 0.0, degC = 0.0;
  };
  double Change() const;

  SoakCommand command_;
  double expected_s_;
  double t_s_ = 0.0;
  std::deque<Reading> window_;
  std::deque<Reading> changes_;  // within the windows that ended during the last one
  double change_degC_;
};

}  // namespace gyrobench::procedures
