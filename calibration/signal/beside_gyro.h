// What is sampled beside the gyro, as means between times.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "base/geometry.h"
#include "base/measurement.h"

namespace gyrobench::calibration {

// Samples come ahead of the readings of the reference whose times part them, and wait here for
// those. Bounded: of more than wait at once the oldest count for the next mean, whatever its time.
// Nothing is allocated per sample.
class BesideGyro {
 public:
  struct Means {
    double temperature_degC = kMissing;
    Vector3 accel_g = {kMissing, kMissing, kMissing};
    double vibration_g2 = kMissing;  // mean square about the mean; NaN of fewer than four samples
  };

  // `covariates`: how many values a row of them has.
  void Start(std::size_t covariates);
  void Add(const GyroSample& sample);
  void AddCovariates(double t_s, std::span<const double> values);
  // Of what came since the last call and is of no later time. `covariates`: filled; NaN where no
  // value is a number.
  Means TakeUpTo(double t_s, std::vector<double>* covariates);

 private:
  // Values that are not a number do not count.
  struct Mean {
    double sum = 0.0;
    std::int64_t n = 0;
    void Add(double value);
    double Take();
  };
  // Mean square about the mean, of three channels together.
  struct Scatter {
    Vector3 origin = {}, sum = {}, square = {};
    std::int64_t n = 0;
    void Add(const Vector3& value);
    double Take();
  };
  struct Sample {
    double t_s = 0.0, temperature_degC = kMissing;
    Vector3 accel_g = {};
  };
  static constexpr std::size_t kMostWaiting = 512;

  void CountSample();  // the oldest that waits
  void CountCovariates();

  std::array<Sample, kMostWaiting> samples_;
  std::size_t first_sample_ = 0, waiting_samples_ = 0;
  std::vector<double> covariate_times_s_, covariates_;  // rings
  std::size_t columns_ = 0, first_row_ = 0, waiting_rows_ = 0;

  Mean temperature_;
  std::array<Mean, 3> accel_;
  Scatter vibration_;
  std::vector<Mean> covariate_means_;
};

}  // namespace gyrobench::calibration
