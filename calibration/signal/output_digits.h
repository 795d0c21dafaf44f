// The steps in which a channel's samples come, and what rounding to them does at a steady rate.
#pragma once

#include <cstdint>

namespace gyrobench::calibration {

// Where a gyro's noise does not carry its output over the steps of its last digit, the mean of its
// samples is not its rate: it is off by a wave of the rate, of one period a step q,
//   (q / pi) exp(-2 pi^2 sigma^2 / q^2) sin(2 pi w / q)
// (Widrow and Kollar, Quantization Noise, 2008, 4.2), whose phase at a rate nobody knows. `wave` is
// what its amplitude may be at most, `scatter` the standard deviation of a sample, rounded as it
// is; in units of the output. All 0 where no two samples in a row were the same, or noise leaves
// less than a hundredth of a step of the wave.
struct OutputRounding {
  double step = 0.0, wave = 0.0, scatter = 0.0;
};

class OutputDigits {
 public:
  // Finite, in order.
  void Add(double value);
  // The step is the least difference of two samples in a row that is one. Of noise sigma, and levels
  // that lie anywhere between two steps, the next sample is the same with the probability
  //   P = E max(0, 1 - |d| / q),  d ~ N(0, 2 sigma^2),
  // from which sigma is worked out. A table that rests where its output lies on the edge between two
  // steps makes it look up to twice as large. The wave is worked out with the least that sigma may
  // be: half of it or, where P is clearly below 1/2, that of which levels that all lie on an edge
  // give P. Samples that come twice make sigma look smaller.
  OutputRounding Rounding() const;

 private:
  std::int64_t pairs_ = 0, same_ = 0;
  double last_ = 0.0, least_ = 0.0;
  bool any_ = false;
};

}  // namespace gyrobench::calibration
