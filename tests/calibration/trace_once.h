// One trace, and where a test looks at the first channel alone.
#pragma once

#include <cstdint>
#include <span>

#include "calibration/signal/collector.h"
#include "calibration/trace/trace.h"

namespace gyrobench::testing {

// Without the curves of the report, which take time.
calibration::TraceResult TraceAll(std::span<const calibration::Recording* const> inputs,
                                  std::uint64_t seed = calibration::TraceOptions().seed);
calibration::TraceResult TraceAll(const calibration::Recording& recording);
calibration::ChannelTrace TraceOf(std::span<const calibration::Recording* const> inputs,
                                  std::uint64_t seed = calibration::TraceOptions().seed);
calibration::ChannelTrace TraceOf(const calibration::Recording& recording,
                                  std::uint64_t seed = calibration::TraceOptions().seed);

}  // namespace gyrobench::testing
