// A calibration that commands are given.
#pragma once

#include "calibration/artefact/calibration_file.h"

namespace gyrobench::cli {

// w = (xi / 131 - 0.5 - 0.01 (T - 30)) / 1.02
inline calibration::Calibration GyroZ() {
  calibration::Calibration calibration;
  calibration.sensor = "MPU-17";
  calibration::ChannelCalibration channel;
  channel.model.axis = SensorAxis::kZ;
  channel.model.unit = "LSB";
  channel.model.units_per_deg_s = 131.0;
  channel.model.m_row = {0.0, 0.0, 1.02};
  channel.model.reference_degC = 30.0;
  channel.model.bias_deg_s = {0.5, 0.01};
  channel.model.max_rate_deg_s = 40.0;
  channel.model.min_temperature_degC = 20.0;
  channel.model.max_temperature_degC = 40.0;
  calibration.channels.push_back(channel);
  return calibration;
}

}  // namespace gyrobench::cli
