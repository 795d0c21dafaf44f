// The calibration that leaves the bench, calibration.json: docs/calibration.md.
#pragma once

#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "calibration/effects/channel_model.h"
#include "calibration/trace/trace_result.h"

namespace gyrobench::calibration {

inline constexpr const char* kCalibrationFormat = "gyrobench.calibration/1";

// A file that the calibration was made from.
struct CalibrationInput {
  std::string file;    // name without folder
  std::string sha256;  // of its bytes, 64 hexadecimal digits
  std::int64_t samples = 0;
  double duration_s = kMissing;
};

struct ChannelCalibration {
  ChannelModel model;
  Verdict verdict = Verdict::kNone;
  // What the trace promises of data that it did not see.
  HeldOut heldout_whitened_rms;
  HeldOut heldout_angle_rms_deg;
  // Of the output over its nominal sensitivity; NaN where it is not known. `reference_deg` is the
  // bench's and is not written.
  NoiseModel noise = {};
};

struct Calibration {
  std::string sensor;   // serial number, empty where no input says it
  std::string created;  // "2026-11-21T15:30:12Z"
  std::string version;  // of gyrobench
  std::vector<CalibrationInput> inputs;
  std::map<std::string, std::string> configuration;  // of the trace: seed ...
  std::vector<ChannelCalibration> channels;
  std::optional<VectorCalibration> vector = {};  // the channels as one sensor
  // The model's xi is the converter's count less this. Empty: no counts, or a file that does not
  // say it.
  std::optional<double> gyro_lsb_zero = {};
};

// Why a term of a model is no part of a correction, empty where it is one: an effect of reference
// or bench, an event of the run that it was found in, or what no sample can be freed of.
std::string WhyNotApplied(const ModelTerm& term);

// Counts of an axis that was never turned and whose sensitivity nothing gave: how many of them are
// 1 deg/s is not known, and the model has s0 = 1 in its place.
bool ScaleUnknown(const ChannelModel& model);

// All terms are written, with whether they are applied. What is not a number is null.
nlohmann::json ToJson(const Calibration& calibration);

// Reads what ToJson wrote, to the last digit. Throws DataError "cal.json: channels[0].m_row: what,
// expected ...": another format or version, a key that is missing or not known, a value of another
// kind, lists whose lengths do not fit, effects that are not in the catalogue. `file` is for
// messages.
Calibration CalibrationFromJson(const nlohmann::json& json, const std::string& file);

}  // namespace gyrobench::calibration
