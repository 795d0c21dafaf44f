// One part, calibrated on the full sequence with all three axes, and corrected on another one.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/blind_trials/trial.h"

namespace gyrobench::blind_trials {

// One number that the calibration states.
struct StatedNumber {
  std::string group;  // "M", "A", "b", "g-sensitivity", "accelerometer"
  std::string name;   // "xy"
  double estimate = kMissing, truth = kMissing, std_error = kMissing;
  double bound = kMissing;  // NaN: not worked out
};

struct VectorOutcome {
  std::uint64_t seed = 0;
  NoiseKind noise = NoiseKind::kWhite;
  std::vector<StatedNumber> numbers;
  // Of the corrected rates on the sequence that the fit did not see, under the true noise: 1 is the
  // floor.
  std::array<double, 3> elsewhere_whitened_rms = {kMissing, kMissing, kMissing};
  std::string effects;  // what the trace named, "x: bias.g_linear; ..."
  std::string failure;
};

// The part's sensitivities to gravity are drawn as well. The tracer sees the recording alone.
// Mounted on the table by R_mount = Rz Ry Rx; a mounting that is not known belongs to the part.
VectorOutcome RunVectorTrial(std::uint64_t seed, const config::Triple& mount_deg = {},
                             bool mount_known = true);

// RMS of error over bound, RMS of error over standard error, coverage of 95 % intervals, by element
// and by group; the RMS on the unseen sequence.
std::string VectorTable(const std::vector<VectorOutcome>& outcomes);

}  // namespace gyrobench::blind_trials
