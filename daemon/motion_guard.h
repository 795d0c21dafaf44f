// Whether one axis moves as it was commanded: its drive and its reference against the command, and
// against each other.
#pragma once

#include <mutex>
#include <optional>

#include "base/clock.h"
#include "config/stand_config.h"
#include "daemon/fault.h"
#include "daemon/span_guard.h"
#include "drivers/angle_sensor.h"
#include "drivers/axis.h"

namespace gyrobench::daemon {

// What is known of an axis now.
struct AxisView {
  drivers::AxisState drive;
  drivers::AngleReading reference;
};

// Judges each poll of the drive and each reading of the reference. While a move is under way:
//   following  each reading against where the drive was at its time: |moved - drive| <= allowed
//   rate       the reference against the command: moved <= rate * time + allowed
//   target     moved <= commanded + allowed
//   to and fro the span of the reference against that of the drive, over two moves: SpanGuard
//   time       at most half as long again as distance, rate and acceleration make it, and 2 s
// with allowed = following_error_deg + rate * (0.5 s + declared delay of the reference), the rate
// of the move before added in a reversal. Otherwise:
//   rest       a reference that leaves by more than following_error_deg where it came to rest,
//              and a drive that says that it moves
// Where two readings on end are beyond, or one span or poll of the drive, it is a fault, told once.
// How exactly a move ended is judged by who asked for it.
//
// Thread-safe: drive and reference may be on two buses.
class MotionGuard {
 public:
  // The configuration outlives it.
  explicit MotionGuard(const config::AxisConfig& config) : config_(config) {}

  // Something was, or is about to be, sent that may move the axis: until the drive is seen at rest,
  // it may move.
  void MayMove();
  // The drive has taken a move. `begin`: as the axis was before.
  void Begin(const AxisView& begin, double angle_deg, double rate_deg_s,
             double acceleration_deg_s2);
  // Of the reference, the newest reading.
  std::optional<Fault> Polled(const drivers::AxisState& state,
                              const drivers::AngleReading& reference);
  std::optional<Fault> Read(const drivers::AngleReading& reading);
  // What it showed before does not count.
  void ReferenceOpened();
  // Nor its count.
  void DriveOpened();

 private:
  struct Move {
    AxisView begin;
    double angle_deg = 0.0;
    double rate_deg_s = 0.0;
    double allowed_deg = 0.0;
    Utime deadline = 0;
    drivers::AxisState polled;  // at the poll before
    Utime judged = 0;           // time of the reading that was judged last
    int beyond = 0;             // readings on end
  };
  std::optional<Fault> PolledAtRest(const drivers::AxisState& state);
  std::optional<Fault> PolledInMove(const drivers::AxisState& state,
                                    const drivers::AngleReading& reference);
  std::optional<Fault> JudgeReading(const drivers::AxisState& before, const drivers::AxisState& now,
                                    const drivers::AngleReading& reference);
  // Ends the watch over the move.
  Fault Fail(const std::string& message);
  Utime ReferenceAge() const;

  const config::AxisConfig& config_;
  mutable std::mutex mutex_;  // guards what follows
  bool may_move_ = true;      // nobody knows what was commanded before
  std::optional<Move> move_;
  SpanGuard span_;
  double last_rate_deg_s_ = 0.0;  // of the move before
  Utime at_rest_since_ = 0;       // at the latest
  std::optional<double> rest_deg_;
  int left_ = 0;  // readings on end
};

}  // namespace gyrobench::daemon
