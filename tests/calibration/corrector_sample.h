// A sensor of three axes whose forward model is written out by hand, and its correction.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "calibration/artefact/calibration_file.h"
#include "calibration/artefact/corrector.h"

namespace gyrobench::calibration {

inline constexpr double kUnits = 131.0;  // LSB per deg/s
inline constexpr double kInterval_s = 0.01;
inline constexpr double kDuration_s = 60.0;
inline constexpr std::size_t kSamples = 6000;

Vector3 TrueRate(double t);
// Slow enough that lines over 10 s follow it to 1e-4.
double Temperature(double t);
Vector3 Gravity();
double Supply(double t);

MeasurementInfo Info();
Calibration ThreeAxes();

// Of a channel's output, in deg/s.
using Extra = std::function<double(std::size_t channel, double t, const Vector3& w)>;
GyroSample Sample(double t, const Calibration& calibration, const Extra& extra = {});

struct Corrected {
  std::vector<Vector3> rates;
  CorrectionReport report;
};
Corrected Correct(const Calibration& calibration, const MeasurementInfo& info,
                  const std::function<GyroSample(double t)>& sample_at);

double LargestError(const std::vector<Vector3>& rates, std::vector<std::size_t> axes = {0, 1, 2});

ModelTerm Term(const std::string& id, std::vector<double> coefficients,
               std::vector<double> nonlinear = {});
// Both follow the supply.
ModelTerm Empirical();
ModelTerm OfSupply(const std::string& id, double coefficient);

}  // namespace gyrobench::calibration
