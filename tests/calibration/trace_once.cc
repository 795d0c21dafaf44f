#include "tests/calibration/trace_once.h"

namespace gyrobench::testing {

calibration::TraceResult TraceAll(std::span<const calibration::Recording* const> inputs,
                                  std::uint64_t seed) {
  calibration::TraceOptions options;
  options.seed = seed;
  options.curves = false;
  return calibration::Trace(inputs, options).result;
}

calibration::TraceResult TraceAll(const calibration::Recording& recording) {
  const calibration::Recording* const inputs[] = {&recording};
  return TraceAll(inputs);
}

calibration::ChannelTrace TraceOf(std::span<const calibration::Recording* const> inputs,
                                  std::uint64_t seed) {
  return TraceAll(inputs, seed).channels.at(0);
}

calibration::ChannelTrace TraceOf(const calibration::Recording& recording, std::uint64_t seed) {
  const calibration::Recording* const inputs[] = {&recording};
  return TraceOf(inputs, seed);
}

}  // namespace gyrobench::testing
