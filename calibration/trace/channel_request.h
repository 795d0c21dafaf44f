// What is asked of one channel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "calibration/state/state_history.h"
#include "calibration/trace/bench_finding.h"

namespace gyrobench::calibration {

struct ChannelRequest {
  std::span<const StateHistory> histories;
  std::size_t channel = 2;
  double units_per_deg_s = 1.0;
  std::vector<std::string> covariates;
  bool earth_rate_known = false;
  double false_discovery = 0.001;
  std::uint64_t seed = 1;
  bool curves = true;
  bool try_on_rest = true;
  std::vector<BenchFinding> told;  // by any channel, that this one may feel as well
};

}  // namespace gyrobench::calibration
