#include "calibration/signal/beside_gyro.h"

#include <cmath>

namespace gyrobench::calibration {

void BesideGyro::Mean::Add(double value) {
  if (!std::isfinite(value)) return;
  sum += value;
  ++n;
}

double BesideGyro::Mean::Take() {
  const double mean = n > 0 ? sum / static_cast<double>(n) : kMissing;
  *this = {};
  return mean;
}

void BesideGyro::Scatter::Add(const Vector3& value) {
  if (!std::isfinite(value[0] + value[1] + value[2])) return;
  if (n == 0) origin = value;
  ++n;
  for (std::size_t c = 0; c < 3; ++c) {
    const double offset = value[c] - origin[c];
    sum[c] += offset;
    square[c] += offset * offset;
  }
}

double BesideGyro::Scatter::Take() {
  constexpr std::int64_t kLeast = 4;
  double total = 0.0;
  const auto count = static_cast<double>(n);
  for (std::size_t c = 0; c < 3; ++c) total += (square[c] - sum[c] * sum[c] / count) / count;
  const double out = n >= kLeast ? total : kMissing;
  *this = {};
  return out;
}

void BesideGyro::Start(std::size_t covariates) {
  *this = {};
  columns_ = covariates;
  covariate_means_.resize(covariates);
  covariate_times_s_.resize(covariates > 0 ? kMostWaiting : 0);
  covariates_.resize(covariates * kMostWaiting);
}

void BesideGyro::Add(const GyroSample& sample) {
  if (waiting_samples_ == kMostWaiting) CountSample();
  samples_[(first_sample_ + waiting_samples_++) % kMostWaiting] = {
      sample.t_s, sample.temperature_degC, sample.accel_g};
}

void BesideGyro::AddCovariates(double t_s, std::span<const double> values) {
  if (columns_ == 0) return;
  if (waiting_rows_ == kMostWaiting) CountCovariates();
  const std::size_t row = (first_row_ + waiting_rows_++) % kMostWaiting;
  covariate_times_s_[row] = t_s;
  for (std::size_t j = 0; j < columns_; ++j)
    covariates_[row * columns_ + j] = j < values.size() ? values[j] : kMissing;
}

BesideGyro::Means BesideGyro::TakeUpTo(double t_s, std::vector<double>* covariates) {
  while (waiting_samples_ > 0 && !(samples_[first_sample_].t_s > t_s)) CountSample();
  while (waiting_rows_ > 0 && !(covariate_times_s_[first_row_] > t_s)) CountCovariates();
  covariates->clear();
  for (Mean& mean : covariate_means_) covariates->push_back(mean.Take());
  Means means;
  means.temperature_degC = temperature_.Take();
  means.vibration_g2 = vibration_.Take();
  for (std::size_t c = 0; c < 3; ++c) means.accel_g[c] = accel_[c].Take();
  return means;
}

void BesideGyro::CountSample() {
  const Sample& sample = samples_[first_sample_];
  temperature_.Add(sample.temperature_degC);
  vibration_.Add(sample.accel_g);
  for (std::size_t c = 0; c < 3; ++c) accel_[c].Add(sample.accel_g[c]);
  first_sample_ = (first_sample_ + 1) % kMostWaiting;
  --waiting_samples_;
}

void BesideGyro::CountCovariates() {
  for (std::size_t j = 0; j < columns_; ++j)
    covariate_means_[j].Add(covariates_[first_row_ * columns_ + j]);
  first_row_ = (first_row_ + 1) % kMostWaiting;
  --waiting_rows_;
}

}  // namespace gyrobench::calibration
