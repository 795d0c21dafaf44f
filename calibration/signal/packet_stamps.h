// Stamps of samples that come in packets.
#pragma once

#include <cstdint>

#include "base/measurement.h"
#include "calibration/signal/stamp_line.h"

namespace gyrobench::calibration {

// A serial adapter hands over what it has every 16 ms or so: samples of an even clock are then
// stamped a few at once, each late by another part of that, and at 40 deg/s each angle is off by up
// to 0.6 deg, in a beat of the clock with the packets that passes for ripples of the angle. No
// sensor samples twice within a quarter of its mean interval: where many stamps are as close, they
// are put on a straight line through them, by least squares of the last 20 s. Such times are late
// by the mean delay. Where stamps come one by one they stay as they are, and so do the first ones.
// Constant memory; what it gives depends on the stamps so far alone.
class PacketStamps {
 public:
  // In order; samples of one packet may have the same stamp.
  double Mend(double stamp_s);
  bool in_packets() const { return in_packets_; }
  // How many were put on the line; its interval, and the standard deviation of stamps about it [s].
  std::int64_t mended() const { return mended_; }
  double interval_s() const { return OnLine() ? line_.slope_s() : kMissing; }
  double scatter_s() const;

 private:
  void Begin(double stamp_s);
  void LookAtStep(double step_s);
  void Add(double stamp_s);
  void LookForLost(double late_s);
  void EndWindow();
  bool OnLine() const;
  double LineAt() const;

  std::int64_t count_ = 0;  // of this stretch
  double first_s_ = 0.0, last_stamp_s_ = kMissing, last_s_ = kMissing;
  double place_ = 0.0;  // of the last stamp, in intervals from the first one
  StampLine line_;
  // Of the last steps: how many, their mean, and the share of those that no clock makes.
  double steps_ = 0.0, mean_step_s_ = 0.0, share_short_ = 0.0;
  bool in_a_packet_ = false;  // the last one came with the one before
  bool in_packets_ = false;
  std::int64_t mended_ = 0;
  // By how much stamps are behind the line: the least of those of a window, and what that usually
  // is.
  std::int64_t in_window_ = 0, packets_in_window_ = 0, windows_ = 0;
  double least_late_s_ = 0.0, usual_least_s_ = 0.0;
};

}  // namespace gyrobench::calibration
