// Noise of the gyro, three axes.
#pragma once

#include <array>

#include "config/scenario.h"
#include "stand/random.h"

namespace gyrobench::stand {

// Per sample, dt = sample period, n = standard normal numbers:
//   white:    N / sqrt(dt) n                      so that its integral is an angle random walk of N
//   deg/sqrt(s) walk:     b += K sqrt(dt) n                   K in deg/s/sqrt(s) flicker:  sum of
//   first-order Gauss-Markov processes, time constants 1, 4, 16 ... s, whose one-sided
//             spectrum is B^2 / (pi f) between 1/(2 pi 4096 s) and 1/(2 pi s); B in deg/s (IEEE
//             952)
// A fraction of the samples has white noise larger by a factor (heavy tails).
class GyroNoise {
 public:
  GyroNoise(const config::GyroScenario& scenario, std::uint64_t seed);
  // The noise of the next sample [deg/s].
  config::Triple Next(double period_s);
  // The random walk's part of it, for tests.
  const config::Triple& walk_deg_s() const { return walk_deg_s_; }

 private:
  static constexpr std::size_t kProcesses = 7;
  struct Process {
    double decay = 1.0, kick = 0.0;
    config::Triple state = {};
  };
  void SetPeriod(double period_s);
  double Tail();

  const config::GyroScenario& scenario_;
  RandomStream white_, walk_, flicker_, tail_;
  bool has_flicker_;
  double period_s_ = 0.0, root_period_ = 0.0, root_rate_ = 0.0;
  config::Triple walk_deg_s_ = {};
  std::array<Process, kProcesses> processes_;
};

}  // namespace gyrobench::stand
