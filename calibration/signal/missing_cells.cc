#include "calibration/signal/missing_cells.h"

#include <cmath>

namespace gyrobench::calibration {

void MissingCells::Add(double t_s, const GyroSample& sample, const std::array<bool, 3>& present,
                       double longest_s) {
  present_ = present;
  const std::size_t newest = (first_ + count_) % samples_.size();
  samples_[newest] = {t_s, sample, sample.xi};
  ++count_;
  for (std::size_t c = 0; c < 3; ++c) {
    if (!present[c]) continue;
    if (!std::isfinite(sample.xi[c])) {
      ++missing_[c];
      continue;
    }
    if (missing_[c] <= kMostInARow) Fill(c, newest, longest_s);
    missing_[c] = 0;
    last_s_[c] = t_s;
    last_[c] = sample.xi[c];
  }
}

void MissingCells::Fill(std::size_t channel, std::size_t newest, double longest_s) {
  const Sample& end = samples_[newest];
  const double length_s = end.t_s - last_s_[channel];
  if (!(length_s > 0.0) || length_s > longest_s) return;
  for (std::size_t i = 0; i < missing_[channel] && i + 1 < count_; ++i) {
    Sample& missing = samples_[(first_ + count_ - 2 - i) % samples_.size()];
    const double part = (missing.t_s - last_s_[channel]) / length_s;
    missing.xi[channel] = std::lerp(last_[channel], end.xi[channel], part);
  }
}

const MissingCells::Sample* MissingCells::Next() {
  if (count_ == 0 || Waits(samples_[first_])) return nullptr;
  const Sample& next = samples_[first_];
  first_ = (first_ + 1) % samples_.size();
  --count_;
  return &next;
}

bool MissingCells::Waits(const Sample& sample) const {
  for (std::size_t c = 0; c < 3; ++c) {
    if (present_[c] && !std::isfinite(sample.xi[c]) && missing_[c] > 0 &&
        missing_[c] <= kMostInARow)
      return true;
  }
  return false;
}

}  // namespace gyrobench::calibration
