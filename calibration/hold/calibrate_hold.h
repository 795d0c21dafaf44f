// A calibration without a stand: held poses with turns by hand between them. What it says is plain
// values; NaN is what is not known. As JSON: docs/hold.md.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/measurement.h"
#include "calibration/artefact/calibration_file.h"
#include "calibration/hold/hold_noise.h"
#include "calibration/sensor/vector_calibration.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

struct HoldRecording;

struct HoldInput {
  MeasurementInfo info;
  std::int64_t samples = 0;
  double duration_s = 0.0;
  double gyro_rate_hz = kMissing;
  std::int64_t rests = 0, turns = 0;
  std::vector<Defect> defects;
};

// A turn or a rest that is not used.
struct HoldLeftOut {
  std::string what;  // "turn", "rest"
  std::string file;
  double begin_s = kMissing, end_s = kMissing;
  std::string because;
};

// A direction of the sensor that was, or was not, up in some rest.
struct HoldFace {
  std::string up;                 // "+x" ... "-z", axes of the accelerometer
  double nearest_deg = kMissing;  // angle between it and up in the nearest rest
  bool covered = false;           // within 35 deg: nearer than a corner of the cube is
};

struct HoldFinding {
  std::string test;  // "bias.g_linear", "scale.bent", "accel.bent", "turn_noise", "pose_scatter"
  std::string channels;  // "y", "xz"; empty where it is of no single channel
  double p_value = kMissing;
  bool in_model = false;  // taken into the calibration
  std::string says;
};

struct HoldResult {
  std::vector<HoldInput> inputs;
  std::string sensor;
  std::optional<double> gyro_lsb_zero;  // that was taken off the gyro's counts; empty: no counts
  std::int64_t rests = 0, turns = 0;    // used
  double duration_s = 0.0;              // of all inputs
  std::vector<HoldFace> faces;
  std::array<double, 3> turned_deg = {};  // about each axis of the sensor, there and back, in all
  std::vector<HoldLeftOut> left_out;

  // Why there is no calibration; then nothing of what follows is known.
  std::vector<std::string> missing;

  Verdict verdict = Verdict::kUnexplained;
  std::string summary;
  std::vector<HoldFinding> findings;
  std::vector<std::string> remarks;

  std::string unit;                // of xi: LSB, deg/s
  bool sensitivity_given = false;  // else it is from these turns, and the scale factors are 1
  std::array<double, 3> units_per_deg_s = {kMissing, kMissing, kMissing};  // s0
  std::array<double, 3> bias_deg_s = {kMissing, kMissing, kMissing};       // mean over the rests
  std::array<double, 3> bias_std_error_deg_s = {kMissing, kMissing, kMissing};
  double temperature_degC = kMissing;  // mean over the rests
  double min_temperature_degC = kMissing, max_temperature_degC = kMissing;
  double max_rate_deg_s = kMissing;
  VectorCalibration vector;
  HoldNoiseResult noise;
  // Of gravity at the end of each turn as the rotation and the rest before predict it against what
  // the accelerometer says: nominal gyro (NaN where no sensitivity is given), and calibrated.
  double angle_rms_nominal_deg = kMissing, angle_rms_deg = kMissing;
  // Whitened, each turn (rest) as all others predict it; 1 is what the noise explains.
  double turn_whitened_rms = kMissing, accel_whitened_rms = kMissing;

  std::vector<ChannelCalibration> channels;  // for calibration.json
};

inline constexpr const char* kHoldFormat = "gyrobench.hold/1";

// Keys are the names of the fields above. A number that is not known is null.
nlohmann::json ToJson(const HoldResult& result);

struct HoldOptions {
  // The g-sensitivity stays in the model whether it is seen or not.
  bool g_sensitivity = false;
};

// Gyro matrix, offset, g-sensitivity and the accelerometer's own calibration from rests and turns;
// gravity is the reference, and time stamps give the scale. What these poses do not show is said in
// `missing`, and no number is given then. Throws DataError where there is nothing to work with: no
// three axes of gyro or accelerometer, no sample, data of different sensors.
HoldResult CalibrateHold(std::span<const HoldRecording* const> recordings,
                         const HoldOptions& options = {});

}  // namespace gyrobench::calibration
