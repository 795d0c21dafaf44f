// Which figures of a noise are estimates, and which only say that nothing was seen.
#pragma once

#include <string>

#include "calibration/trace/trace_result.h"

namespace gyrobench::presentation {

// One figure of the noise: seen, or below what the others hide.
struct NoiseFigure {
  double value = kMissing;  // NaN: there is none
  double limit = kMissing;  // least that could have been seen
  std::string why;          // what hides it; empty where it was seen or there is none

  bool hidden() const { return !why.empty(); }
};

struct NoiseFigures {
  NoiseFigure angle_random_walk, bias_random_walk, reference;
};

// Of a channel traced over `duration_s` (the longest of its measurements). Likelihood ends at a
// bound where a noise is too small: its figure there, 0 or 3e-09, is no finding. With N, K, R the
// angle random walk, bias random walk and reference noise, T the duration and dt = 0.1 s, a mean
// over all of T is the least noise that the next slower one has to be seen in:
//   N is hidden where N sqrt(T) < R sqrt(dt / T)
//   K is hidden where K sqrt(T) < N / sqrt(T)
//   R is hidden where R < N sqrt(dt) (dt / T)^1/4, a variance known from T / dt walks
NoiseFigures JudgeNoise(const calibration::NoiseModel& noise, double duration_s);

// The longest of the measurements [s].
double LongestDuration_s(const calibration::TraceResult& trace);

}  // namespace gyrobench::presentation
