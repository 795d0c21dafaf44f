#include "daemon/motion_guard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "procedures/engine/motion_time.h"

namespace gyrobench::daemon {
namespace {

// A reference may be so much older than the drive's word, beside the delay that its map declares:
// one that nobody declared is a finding of the analysis, not a fault.
constexpr double kUndeclaredAge_s = 0.5;
constexpr int kReadingsBeyond = 2;
constexpr double kLongest = 1.5;     // of the time that a move should take
constexpr double kPatience_s = 2.0;  // beside that

}  // namespace

Utime MotionGuard::ReferenceAge() const {
  return FromSeconds(kUndeclaredAge_s + config_.encoder.map.delay_s);
}

void MotionGuard::MayMove() {
  const std::lock_guard lock(mutex_);
  may_move_ = true;
}

// A reference shows the table as it was `age` ago, so a move by r deg/s seems to lag by r * age.
// In a reversal, and wherever the axis was moving within that time, so does the reading that the
// move is counted from, by the rate of the move before, and the other way.
void MotionGuard::Begin(const AxisView& begin, double angle_deg, double rate_deg_s,
                        double acceleration_deg_s2) {
  const std::lock_guard lock(mutex_);
  const bool just_moved =
      last_rate_deg_s_ > 0 && begin.drive.utime - at_rest_since_ < ReferenceAge();
  const double before_deg_s = move_ ? move_->rate_deg_s : just_moved ? last_rate_deg_s_ : 0.0;
  const double longest_s =
      kLongest * procedures::MoveDuration_s(angle_deg, rate_deg_s, acceleration_deg_s2) +
      kPatience_s;
  move_ = Move{.begin = begin,
               .angle_deg = angle_deg,
               .rate_deg_s = rate_deg_s,
               .allowed_deg = config_.following_error_deg +
                              (rate_deg_s + before_deg_s) * ToSeconds(ReferenceAge()),
               .deadline = begin.drive.utime + FromSeconds(longest_s),
               .polled = begin.drive,
               .judged = begin.reference.utime};
  span_.Begin(begin.drive, rate_deg_s, ReferenceAge());
  may_move_ = true;
}

std::optional<Fault> MotionGuard::Polled(const drivers::AxisState& state,
                                         const drivers::AngleReading& reference) {
  const std::lock_guard lock(mutex_);
  span_.Polled(state);
  if (!state.moving) {
    if (move_) last_rate_deg_s_ = move_->rate_deg_s;
    if (may_move_) at_rest_since_ = state.utime;
    move_.reset();
    may_move_ = false;
    return std::nullopt;
  }
  return move_ ? PolledInMove(state, reference) : PolledAtRest(state);
}

std::optional<Fault> MotionGuard::PolledAtRest(const drivers::AxisState& state) {
  if (std::exchange(may_move_, true)) return std::nullopt;
  return Fail(
      fmt::format("the drive moves, at {:.3f} deg, though nobody commanded it: stopped. Look "
                  "for another master on its line, or an input of the drive that starts it",
                  state.commanded_deg));
}

std::optional<Fault> MotionGuard::PolledInMove(const drivers::AxisState& state,
                                               const drivers::AngleReading& reference) {
  if (state.utime > move_->deadline) {
    return Fail(fmt::format(
        "the drive still moves {:.1f} s after the start of a move of {:g} deg at {:g} deg/s that "
        "should have taken {:.1f} s: stopped. Look for a load that brakes it, or a wrong "
        "pulses_per_turn or gear_ratio in the stand file",
        ToSeconds(state.utime - move_->begin.drive.utime), move_->angle_deg, move_->rate_deg_s,
        (ToSeconds(move_->deadline - move_->begin.drive.utime) - kPatience_s) / kLongest));
  }
  const drivers::AxisState before = std::exchange(move_->polled, state);
  // Each reading once, as late as it comes: one that is silent is told as such.
  if (reference.utime <= move_->judged) return std::nullopt;
  move_->judged = reference.utime;
  return JudgeReading(before, state, reference);
}

std::optional<Fault> MotionGuard::JudgeReading(const drivers::AxisState& before,
                                               const drivers::AxisState& now,
                                               const drivers::AngleReading& reference) {
  const Move& move = *move_;
  double share = 1.0;  // of the time between the polls, at which the reading was taken
  if (now.utime > before.utime) {
    share = ToSeconds(reference.utime - before.utime) / ToSeconds(now.utime - before.utime);
  }
  const double drive_deg =
      std::lerp(before.commanded_deg, now.commanded_deg, std::clamp(share, 0.0, 1.0)) -
      move.begin.drive.commanded_deg;
  const double moved_deg = reference.angle_deg - move.begin.reference.angle_deg;
  const double along_deg = std::copysign(1.0, move.angle_deg) * moved_deg;
  const double time_s = std::max(0.0, ToSeconds(reference.utime - move.begin.drive.utime));
  const bool follows = std::abs(moved_deg - drive_deg) <= move.allowed_deg;
  const bool too_fast = along_deg > move.rate_deg_s * time_s + move.allowed_deg;
  const bool too_far = along_deg > std::abs(move.angle_deg) + move.allowed_deg;
  move_->beyond = follows && !too_fast && !too_far ? 0 : move.beyond + 1;
  if (move.beyond < kReadingsBeyond) return std::nullopt;
  if (too_far) {
    return Fail(
        fmt::format("the table runs past its target: the reference sensor moved {:.3f} deg, "
                    "commanded {:.3f} deg: stopped. Look for a wrong gear ratio, pulses per "
                    "turn or encoder resolution in the stand file",
                    moved_deg, move.angle_deg));
  }
  if (too_fast) {
    return Fail(
        fmt::format("the table turns faster than commanded: {:.3f} deg within {:.2f} s by "
                    "the reference sensor, commanded {:.3g} deg/s: stopped. Look for a wrong "
                    "gear ratio, pulses per turn or encoder resolution in the stand file",
                    moved_deg, time_s, move.rate_deg_s));
  }
  return Fail(fmt::format(
      "the table does not follow its drive: in the move under way the reference sensor moved "
      "{:.3f} "
      "deg, the drive {:.3f} deg, allowed difference {:.3g} deg: stopped (lost steps, a loose "
      "coupling, a reference that is frozen, or a wrong gear ratio or encoder resolution in the "
      "stand file?)",
      moved_deg, drive_deg, move.allowed_deg));
}

Fault MotionGuard::Fail(const std::string& message) {
  if (move_) last_rate_deg_s_ = move_->rate_deg_s;
  move_.reset();
  span_.Forget();
  return {"axis." + config_.name, message, {.device = "axis." + config_.name, .action = "move"}};
}

void MotionGuard::ReferenceOpened() {
  const std::lock_guard lock(mutex_);
  rest_deg_.reset();
  left_ = 0;
  span_.Forget();
}

void MotionGuard::DriveOpened() {
  const std::lock_guard lock(mutex_);
  span_.Forget();
}

std::optional<Fault> MotionGuard::Read(const drivers::AngleReading& reading) {
  const std::lock_guard lock(mutex_);
  if (const auto excess = span_.Read(reading, config_.following_error_deg)) {
    return Fail(fmt::format(
        "the table does not follow its drive: while that was turned to and fro by {:.3f} deg the "
        "reference sensor went over {:.3f} deg, allowed difference {:.3g} deg: stopped (a jammed "
        "table, lost steps, a loose coupling, or a reference that is frozen?)",
        excess->drive_deg, excess->reference_deg, excess->allowed_deg));
  }
  if (may_move_ || reading.utime < at_rest_since_ + ReferenceAge()) {
    rest_deg_.reset();
    return std::nullopt;
  }
  if (!rest_deg_) rest_deg_ = reading.angle_deg;
  const double left_deg = reading.angle_deg - *rest_deg_;
  left_ = std::abs(left_deg) <= config_.following_error_deg ? 0 : left_ + 1;
  if (left_ < kReadingsBeyond) return std::nullopt;
  rest_deg_ = reading.angle_deg;
  left_ = 0;
  return Fail(fmt::format(
      "the table moves though nobody commanded it: {:.3f} deg from where it came to rest, by the "
      "reference sensor, allowed {:g} deg. All axes were told to stop; where it still moves, use "
      "the "
      "emergency stop. Look for a drive without holding current, a load out of balance, a slipping "
      "coupling, or a hand on the table",
      left_deg, config_.following_error_deg));
}

}  // namespace gyrobench::daemon
