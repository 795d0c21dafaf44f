// Whether samples come in packets.
#pragma once

#include <array>
#include <cstddef>

#include "base/measurement.h"

namespace gyrobench::calibration {

// No sensor samples twice within a quarter of its mean interval: where many stamps are as close, in
// several packets among the last 128 steps and the 128 before, they are those of packets. A pause,
// a step of more than twice what the third longest is, says nothing of the interval.
class PacketWatch {
 public:
  // Step of a stamp [s]. `of_other_axes`: the sample has none of the axes of the one before, as
  // where each axis has rows of its own.
  void Take(double step_s, bool of_other_axes);
  bool in_packets() const { return in_packets_; }
  // Stamps in milliseconds may step by one within a packet; what comes one by one is one each.
  bool BeginsPacket(double step_s) const {
    return in_packets_ ? step_s > 0.5 * packet_s_ : !Within(step_s);
  }
  // Mean step, pauses left out, and the longest usual one [s]; NaN at first.
  double mean_step_s() const { return mean_step_s_; }
  double packet_s() const { return packet_s_; }

 private:
  static constexpr std::size_t kSteps = 128, kLeastPackets = 4;
  static constexpr double kShort = 0.25;

  bool Within(double step_s) const { return step_s < kShort * mean_step_s_; }
  bool IsOneBurst();
  std::size_t CountWithin() const;
  bool BlockIsOfPackets();

  std::array<double, kSteps> steps_s_ = {};
  std::size_t count_ = 0, of_other_axes_ = 0;
  double mean_step_s_ = kMissing, packet_s_ = kMissing;
  bool last_block_ = false, in_packets_ = false;
  int bursts_ = 0;  // in a row
};

}  // namespace gyrobench::calibration
