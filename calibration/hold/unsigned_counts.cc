#include "calibration/hold/unsigned_counts.h"

#include <algorithm>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr double kZero = 32768.0;
constexpr double kNearZero = 8192.0;  // a quarter of the range
constexpr std::size_t kSamples = 33;

}  // namespace

std::vector<GyroSample> UnsignedCounts::Add(const GyroSample& sample) {
  if (!counts_) return {sample};
  if (decided_) return {Centred(sample)};
  waiting_.push_back(sample);
  if (waiting_.size() < kSamples) return {};
  return Flush();
}

std::vector<GyroSample> UnsignedCounts::Flush() {
  if (!decided_) Decide();
  std::vector<GyroSample> ready;
  for (const GyroSample& sample : waiting_) ready.push_back(Centred(sample));
  waiting_.clear();
  return ready;
}

void UnsignedCounts::Decide() {
  decided_ = true;
  for (std::size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const GyroSample& sample : waiting_)
      if (std::isfinite(sample.xi[c])) values.push_back(sample.xi[c]);
    if (values.empty()) continue;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    if (std::fabs(*middle - kZero) < kNearZero) zero_[c] = kZero;
  }
}

GyroSample UnsignedCounts::Centred(GyroSample sample) const {
  for (std::size_t c = 0; c < 3; ++c) sample.xi[c] -= zero_[c];
  return sample;
}

}  // namespace gyrobench::calibration
