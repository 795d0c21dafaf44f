// Nodes and ends of rests whose readings have come before the gyro's samples of their time.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "calibration/signal/columns.h"
#include "calibration/signal/node_readings.h"
#include "calibration/signal/reference_track.h"

namespace gyrobench::calibration {

// What waits for the gyro's samples to reach its time.
struct Pending {
  enum class Kind { kNode, kRestBegin, kRestEnd };
  Kind kind = Kind::kNode;
  double ready_s = 0.0;           // when the gyro has come so far, it can be done
  Node node;                      // kNode
  std::array<bool, 3> read = {};  // the axes that were read at its time
  bool stale = false;             // another had begun to turn, and was not read yet
  bool averaged = false;          // the means are those of its time
  bool moves = false;             // an axis of the reference turns
  NodeReadings readings;          // since the node before
  std::vector<double> covariates;
  double coarse_s = 0.0, moving_s = 0.0;
  OpenRest rest;  // kRestEnd
};

// Waiting jobs, in order. Bounded: a gyro that stays away cannot fill the memory.
class PendingQueue {
 public:
  bool empty() const { return size_ == 0; }
  const Pending& front() const { return jobs_[head_]; }
  std::size_t size() const { return size_; }
  Pending& operator[](std::size_t i) { return jobs_[(head_ + i) % kCapacity]; }
  void pop() {
    head_ = (head_ + 1) % kCapacity;
    --size_;
  }
  // Of nodes since then at readings of other axes.
  void MarkStale(double since_s, std::size_t axis) {
    for (std::size_t i = 0; i < size_; ++i) {
      Pending& job = (*this)[i];
      if (!job.read[axis] && job.node.at.t_s > since_s) job.stale = true;
      job.readings.ForgetFrom(since_s);
    }
  }
  Pending& back() { return jobs_[(head_ + size_ - 1) % kCapacity]; }
  bool push(const Pending& job) {
    if (size_ == kCapacity) return false;
    jobs_[(head_ + size_) % kCapacity] = job;
    ++size_;
    return true;
  }

 private:
  static constexpr std::size_t kCapacity = 256;
  std::vector<Pending> jobs_ = std::vector<Pending>(kCapacity);
  std::size_t head_ = 0, size_ = 0;
};

}  // namespace gyrobench::calibration
