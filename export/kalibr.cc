// Format `kalibr`: the gyro's half of an imu.yaml, noise densities in Kalibr's units
// (docs/calibration.md has the sources).
#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "base/geometry.h"
#include "export/formats.h"
#include "export/text.h"

namespace gyrobench::exporting {
namespace {

using calibration::ChannelCalibration;

double DensityOf(const ChannelCalibration& channel) {
  return kRadPerDeg * channel.noise.angle_random_walk_deg_sqrt_s;
}
double WalkOf(const ChannelCalibration& channel) {
  return kRadPerDeg * channel.noise.bias_random_walk_deg_s_sqrt_s;
}

// Of all axes: Kalibr has one figure for the three. NaN where none is known.
double Largest(const calibration::Calibration& calibration,
               double (*figure)(const ChannelCalibration&)) {
  double largest = kMissing;
  for (const ChannelCalibration& channel : calibration.channels)
    largest = std::fmax(largest, figure(channel));
  return largest;
}

Lines AxisLines(const calibration::Calibration& calibration) {
  Lines lines = {"Axis by axis; the file has the largest, as Kalibr knows one figure for all:"};
  for (const ChannelCalibration& channel : calibration.channels) {
    lines.push_back(
        fmt::format("  gyro {}: noise density {} rad/s/sqrt(Hz), random walk {} "
                    "rad/s^2/sqrt(Hz)",
                    kAxisNames[static_cast<std::size_t>(channel.model.axis)], DensityOf(channel),
                    WalkOf(channel)));
  }
  return lines;
}

// Kalibr takes figures above 0 only.
std::string Entry(const char* key, double value, const char* unit) {
  if (!(value > 0.0))
    return fmt::format("# {}:   # [{}] not to be seen in the data: fill in\n", key, unit);
  return fmt::format("{}: {:.9e}  # [{}]\n", key, value, unit);
}

Lines Notes(const calibration::Calibration& calibration, const LinearModel& model, double walk) {
  Lines notes = WhatNoCorrectionHolds(calibration, model);
  if (!(walk > 0.0)) {
    notes.push_back(
        "gyroscope_random_walk is not written: the data did not show it; record a longer rest");
  }
  notes.push_back(
      "the bias against temperature, scale factor, misalignment and effects are left out: Kalibr's "
      "IMU file holds noise; correct the rates first, by the formats c or json or by gyrobench "
      "apply");
  notes.push_back(
      "update_rate, rostopic and the accelerometer's figures are not written: fill them in");
  return notes;
}

}  // namespace

Exported WriteKalibr(const calibration::Calibration& calibration, const Origin& origin) {
  const LinearModel model = MakeLinearModel(calibration);
  const double density = Largest(calibration, DensityOf), walk = Largest(calibration, WalkOf);
  if (!(density > 0.0)) {
    throw DataError(fmt::format(
        "{}: no noise in it, and Kalibr's file is of noise: it was made by an older gyrobench, or "
        "of data that did not show it; make it again: gyrobench trace FILE... --calibration {}",
        origin.file, origin.file));
  }
  Exported out;
  out.warnings = SetToZero(calibration);
  out.notes = Notes(calibration, model, walk);
  Lines about = OriginLines(calibration, origin);
  about[0] = "Noise of a gyro for Kalibr. " + about[0];
  Append(&about,
         {"",
          "Formula: a sample at intervals dt has noise of standard deviation noise_density / "
          "sqrt(dt), and the bias moves by random_walk sqrt(dt) from one to the next.",
          "Units: noise density rad/s/sqrt(Hz), random walk rad/s^2/sqrt(Hz); of the output over "
          "its nominal sensitivity.",
          ""});
  Append(&about, ValidityLines(model));
  Append(&about, AxisLines(calibration));
  Append(&about,
         {fmt::format("Worked example: at 200 Hz one sample has a noise of {:.6g} rad/s, and the "
                      "angle after 100 s one of {:.6g} rad (without the bias's walk).",
                      density * std::sqrt(200.0), density * std::sqrt(100.0))});
  Append(&about, NoteLines(out.notes));
  out.text = Commented(about, "# ") + "\n" +
             Entry("gyroscope_noise_density", density, "rad/s/sqrt(Hz)") +
             Entry("gyroscope_random_walk", walk, "rad/s^2/sqrt(Hz)") +
             "# accelerometer_noise_density:   # [m/s^2/sqrt(Hz)] fill in\n"
             "# accelerometer_random_walk:   # [m/s^3/sqrt(Hz)] fill in\n"
             "# update_rate:   # [Hz] of the topic: fill in\n"
             "# rostopic:   # fill in\n";
  return out;
}

}  // namespace gyrobench::exporting
