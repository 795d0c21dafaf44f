// What tests put into a measurement, and whether the trace finds its numbers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "calibration/trace/trace_result.h"
#include "tests/calibration/synthetic_bench.h"

namespace gyrobench::testing {

// A number put in. `within`: for those that have no standard error.
struct Expected {
  const char* name;
  double value;
  double within = 0.0;
};

// Whether it is within four standard errors of what the trace states, and the error small enough
// for that to say something.
void ExpectWithinItsInterval(const std::vector<calibration::ModelParameter>& parameters,
                             const Expected& expected);

std::vector<std::string> NamesOf(const calibration::ChannelTrace& channel);

Injection Rate(std::function<double(const BenchState&)> rate);
Injection Angle(std::function<double(const BenchState&)> angle);
inline double Wz(const BenchState& s) { return s.rate_deg_s[2]; }
// The gyro is late: a reading of its time shows what the gyro will see 12 ms later.
Injection Latency(const SyntheticBench& bench);

}  // namespace gyrobench::testing
