// How long a sensor unit has been on.
#pragma once

#include <cstdint>
#include <optional>

namespace gyrobench::drivers {

// Time since the unit's start by its tick, of which only what is left of whole wraps is known: its
// sample number, which wraps much later, tells how many there were. Empty where tick and number do
// not agree (the unit has also sampled at another rate, or sleeps between samples), or after so
// long that they agree with one wrap more as well: then nobody knows.
std::optional<double> SecondsSinceBoot(double tick_s, double tick_wrap_s,
                                       std::int64_t samples_since_boot, double sample_rate_hz);

}  // namespace gyrobench::drivers
