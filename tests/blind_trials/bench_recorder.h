// Records the virtual stand's physics without buses and drivers: what the recording of a run gives,
// in a fraction of the time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "base/measurement.h"
#include "config/scenario.h"
#include "config/stand_config.h"
#include "tests/blind_trials/sequence.h"

namespace gyrobench::blind_trials {

// The truth at a sample, for what is added to the physics.
struct SampleTruth {
  double t_s = 0.0;  // since power-on
  double die_degC = 0.0;
  double rate_z_deg_s = 0.0;     // of the table about the sensor's z
  std::array<double, 3> g = {};  // specific force at rest, frame S
  double supply_v = kMissing;    // of the supply, where it is recorded
};

struct RecorderOptions {
  std::array<bool, 3> channels = {true, true, true};
  double reference_rate_hz = 10.0;  // each of the three axes
  // Otherwise the recording does not say where the stand is; the Earth turns all the same.
  bool latitude_known = true;
  // Records a wandering supply voltage as the column supply_v.
  bool supply = false;
  // Added to the output of z [deg/s].
  std::function<double(const SampleTruth&)> extra_z_deg_s;
  // The clock that stamps the gyro's samples is fast by this.
  double gyro_clock_rel = 0.0;
  // Name for messages, and of the power-on. It must say nothing of what is in the data.
  std::string source = "recording";
};

// Sends the recording of `specimen` (see stand::DrawSpecimen) doing `sequence` into `sink`,
// power-on at 0 s. Gyro at 100 Hz behind its 256 Hz filter, read at the sample instants; the
// reference is read exactly at its time stamps. The sequence's fans are those that blow.
void Record(const config::StandConfig& stand, config::Scenario specimen, const Sequence& sequence,
            std::uint64_t noise_seed, const RecorderOptions& options, MeasurementSink& sink);

}  // namespace gyrobench::blind_trials
