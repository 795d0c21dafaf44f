#include "calibration/signal/packet_watch.h"

#include <algorithm>
#include <functional>

namespace gyrobench::calibration {

void PacketWatch::Take(double step_s, bool of_other_axes) {
  steps_s_[count_++] = step_s;
  of_other_axes_ += of_other_axes ? 1 : 0;
  if (count_ < kSteps) return;
  count_ = 0;
  if (IsOneBurst()) return;
  const bool block = BlockIsOfPackets();
  if (block == last_block_) in_packets_ = block;
  last_block_ = block;
  of_other_axes_ = 0;
}

// Hardly a step between packets: what waited for a host that paused. Not for long, though.
bool PacketWatch::IsOneBurst() {
  constexpr int kMostInARow = 8;
  const bool burst = in_packets_ && kSteps - CountWithin() < kLeastPackets && bursts_ < kMostInARow;
  bursts_ = burst ? bursts_ + 1 : 0;
  return burst;
}

std::size_t PacketWatch::CountWithin() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(steps_s_, [this](double step_s) { return Within(step_s); }));
}

bool PacketWatch::BlockIsOfPackets() {
  constexpr double kPause = 2.0;
  // Of an adapter that makes packets of 1.2 samples a sixth of the steps are short; of stamps that
  // are late by exponential times of a third of the interval a twentieth.
  constexpr double kMany = 0.15, kFew = 0.05;
  constexpr std::size_t kMostOfOtherAxes = kSteps / 10;
  std::array<double, kSteps> longest_first = steps_s_;
  std::ranges::partial_sort(longest_first, longest_first.begin() + 3, std::greater());
  packet_s_ = longest_first[2];
  double sum_s = 0.0, count = 0.0;
  for (const double step_s : steps_s_) {
    if (step_s > kPause * packet_s_) continue;
    sum_s += step_s;
    count += 1.0;
  }
  mean_step_s_ = sum_s / count;
  const std::size_t within = CountWithin();
  const double least = (in_packets_ ? kFew : kMany) * static_cast<double>(kSteps);
  return static_cast<double>(within) > least && kSteps - within >= kLeastPackets &&
         of_other_axes_ <= kMostOfOtherAxes;
}

}  // namespace gyrobench::calibration
