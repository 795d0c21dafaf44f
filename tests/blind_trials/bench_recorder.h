// Records the virtual stand's physics without buses and drivers: what the recording of a run gives,
// in a fraction of the time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
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
  // What the recording says of the stand; the specimen's is the truth.
  StandGeometry geometry = {};
  // Records a wandering supply voltage as the column supply_v.
  bool supply = false;
  // Added to the output of z [deg/s].
  std::function<double(const SampleTruth&)> extra_z_deg_s;
  // The clock that stamps the gyro's samples is fast by this.
  double gyro_clock_rel = 0.0;
  // Name for messages, and of the power-on. It must say nothing of what is in the data.
  std::string source = "recording";
};

// A recording that is made step by step: what the stand does next may depend on what was recorded.
// Power-on at 0 s. Gyro at 100 Hz behind its 256 Hz filter, read at the sample instants; the
// reference is read exactly at its time stamps.
class BenchRecorder {
 public:
  // All arguments must outlive it. `specimen`: see stand::DrawSpecimen; its fans blow.
  BenchRecorder(const config::StandConfig& stand, const config::Scenario& specimen,
                std::uint64_t noise_seed, const RecorderOptions& options, MeasurementSink& sink);
  ~BenchRecorder();
  // Begins no earlier than what has been recorded, nor before the turn before.
  void Add(const Turn& turn);
  // Ends no earlier than the segment before.
  void Add(const SegmentMark& segment);
  // Somebody switches the fan, now.
  void SetFan(bool blows);
  // Records up to the last reading of the reference that is not after `t_s`.
  void RunTo(double t_s);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// Sends the recording of `specimen` (see stand::DrawSpecimen) doing `sequence` into `sink`;
// the sequence's fans are those that blow.
void Record(const config::StandConfig& stand, config::Scenario specimen, const Sequence& sequence,
            std::uint64_t noise_seed, const RecorderOptions& options, MeasurementSink& sink);

}  // namespace gyrobench::blind_trials
