#include "calibration/signal/packet_stamps.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr double kSureFrom = 64.0;  // stamps
constexpr double kShortMemory_s = 20.0;
// A clock of 100 Hz and packets of 4 ms beat within a minute: a line through less goes along with
// that. One through more lags behind a clock that warms up, and leaves more of the stamps then.
constexpr double kLongMemory_s = 100.0, kLongLeavesMore = 1.25;
constexpr double kLongestSilence_s = 2.0;
// Standard deviations about the line. What is later came after a pause of the host, and says
// nothing of the clock; what stays so does.
constexpr double kLatest = 3.0, kLeastPause = 0.5;  // that of the interval
constexpr double kLongestWait_s = 1.0;
constexpr std::int64_t kUsualWindows = 8;

}  // namespace

double PacketStamps::TimeOf(double stamp_s, bool of_other_axes) {
  if (!std::isfinite(stamp_s)) return stamp_s;
  const double step_s = stamp_s - last_stamp_s_;
  last_stamp_s_ = stamp_s;
  wrong_since_s_ = kMissing;
  ++stamps_;
  of_other_axes_ += of_other_axes ? 1 : 0;
  const bool goes_on = step_s >= 0.0 && step_s <= kLongestSilence_s;
  if (goes_on) watch_.Take(step_s, of_other_axes);
  if (!goes_on || !mends() || !on_ || IsEarlyGap(step_s)) {
    on_ = mends();
    if (on_) Begin(stamp_s);
    return last_s_ = held_ ? first_s_ + LineAt() : stamp_s;
  }
  if (watch_.BeginsPacket(step_s)) {
    EndPacket();
    packet_begin_s_ = stamp_s;
  }
  packet_end_s_ = stamp_s;
  Add(stamp_s);
  ++on_line_;
  return last_s_ = std::max(first_s_ + LineAt(), JustAfter(last_s_));
}

// Before it is known what is usual a gap would pass for a slower clock.
bool PacketStamps::IsEarlyGap(double step_s) const {
  constexpr double kIntervals = 4.0, kOfPackets = 2.0;
  return !LossesShow() &&
         step_s > std::max(kIntervals * RoughInterval_s(), kOfPackets * watch_.packet_s());
}

// Whether it is known by how much samples are late by least: of a clock that is known well, at
// once.
bool PacketStamps::LossesShow() const {
  constexpr double kKnownWell = 500.0;  // stamps
  return windows_ == kUsualWindows || (windows_ > 0 && even_.told_by > kKnownWell);
}

// The clock goes on as it was, from another time on.
void PacketStamps::Begin(double stamp_s) {
  const double step_s = LineIsSure() ? short_.slope_s() : RoughInterval_s();
  first_s_ = stamp_s;
  count_ = 1;
  place_ = late_s_ = 0.0;
  short_ = long_ = {};
  short_.step_s = long_.step_s = step_s;
  short_.square = long_.square = std::pow(even_.told_by, 3) / 12.0;
  held_ = stamp_s == even_.first_stamp_s;
  if (held_) {
    short_.step_s = long_.step_s = even_.interval_s;
    short_.mean_s = long_.mean_s = even_.line_less_first_s;
  }
  share_of_long_ = 1.0;
  whole_.Begin(stamp_s);
  samples_ = packets_ = windows_ = 0;
  packet_begin_s_ = packet_end_s_ = stamp_s;
  window_before_s_ = window_s_ = stamp_s;
}

void PacketStamps::Add(double stamp_s) {
  ++count_;
  ++samples_;
  place_ += 1.0;
  double since_first_s = stamp_s - first_s_;
  if (LineIsSure()) {
    late_s_ = since_first_s - LineAt();
    interval_s_ = std::lerp(short_.slope_s(), long_.slope_s(), share_of_long_);
    scatter_s_ = std::sqrt(std::max({short_.left_s2(), long_.left_s2(), 0.0}));
    const double latest_s = LineAt() + std::max(kLatest * scatter_s_, kLeastPause * interval_s_);
    late_in_a_row_ = since_first_s > latest_s ? late_in_a_row_ + 1 : 0;
    if (late_in_a_row_ > 0 && static_cast<double>(late_in_a_row_) * interval_s_ < kLongestWait_s)
      return;
    since_first_s = std::min(since_first_s, latest_s);
  }
  whole_.Add(place_, since_first_s);
  if (held_) return;
  const double memory = std::max(kShortMemory_s / RoughInterval_s(), kSureFrom);
  short_.Add(place_, since_first_s, memory);
  long_.Add(place_, since_first_s, kLongMemory_s / kShortMemory_s * memory);
  const bool long_is_right = long_.left_s2() < kLongLeavesMore * short_.left_s2();
  share_of_long_ = std::clamp(share_of_long_ + (long_is_right ? 1.0 : -1.0) / memory, 0.0, 1.0);
  if (!LineIsSure() || !std::has_single_bit(static_cast<std::uint64_t>(count_))) return;
  short_.MakeStepsItsOwn();
  long_.MakeStepsItsOwn();
}

// The last sample of a packet is late by less than an interval, and what reading it takes. Samples
// that are lost make it later by as many intervals. After a pause of the host it is not, for all
// that waited come at once.
void PacketStamps::EndPacket() {
  constexpr std::int64_t kInWindow = 32, kPackets = 4;
  // Intervals, and of a packet; of single ones over a window, where an interval does not drown in
  // what the host takes.
  constexpr double kSurelyLost = 1.5, kOfPacket = 0.5, kLostShare = 0.7, kSeenFrom_s = 4e-3;
  if (!LineIsSure()) return;
  const double late_s = late_s_ - (packet_end_s_ - packet_begin_s_);
  const double beyond_s = late_s - usual_least_s_;
  const double most_s = kSurelyLost * interval_s_ + kOfPacket * watch_.packet_s();
  if (LossesShow() && std::fabs(beyond_s) > most_s) return Skip(beyond_s);
  least_late_s_ = packets_ == 0 ? late_s : std::min(least_late_s_, late_s);
  if (++packets_ < kPackets || samples_ < kInWindow) return;
  const double beyond_of_all_s = least_late_s_ - usual_least_s_;
  if (LossesShow() && interval_s_ > kSeenFrom_s &&
      std::fabs(beyond_of_all_s) > kLostShare * interval_s_)
    return Skip(beyond_of_all_s);
  samples_ = packets_ = 0;
  window_before_s_ = window_s_;
  window_s_ = last_s_;
  windows_ = std::min(windows_ + 1, kUsualWindows);
  usual_least_s_ += (least_late_s_ - usual_least_s_) / static_cast<double>(windows_);
}

// From somewhere in the window before on the times were off by as much. What no loss explains
// begins anew.
void PacketStamps::Skip(double beyond_s) {
  const double lost = std::round(beyond_s / interval_s_);
  if (!(std::fabs(beyond_s) < kLongestSilence_s)) return Begin(last_stamp_s_);
  place_ += lost;
  lost_ += static_cast<std::int64_t>(lost);
  wrong_since_s_ = window_before_s_;
  samples_ = packets_ = 0;
  window_before_s_ = window_s_ = last_s_;
}

// A line with a memory of so many stamps tells its interval as one through 2.3 times as many does.
KnownClock PacketStamps::Clock() const {
  constexpr double kAsMany = 2.3, kMostOfOtherAxes = 0.1;
  if (static_cast<double>(of_other_axes_) > kMostOfOtherAxes * static_cast<double>(stamps_))
    return {};
  if (!std::isfinite(interval_s_)) return {watch_.mean_step_s(), 0.0};
  // What is farther from the line than packets and intervals are long is no beat of theirs.
  const KnownClock whole = whole_.Clock(0.5 * std::max(interval_s_, watch_.packet_s()));
  if (std::isfinite(whole.interval_s)) return whole;
  const double memory_s = share_of_long_ > 0.5 ? kLongMemory_s : kShortMemory_s;
  return {interval_s_, std::min(static_cast<double>(on_line_), kAsMany * memory_s / interval_s_)};
}

double PacketStamps::RoughInterval_s() const {
  return std::isfinite(even_.interval_s) ? even_.interval_s : watch_.mean_step_s();
}

bool PacketStamps::LineIsSure() const { return static_cast<double>(count_) >= kSureFrom; }

double PacketStamps::LineAt() const {
  if (!LineIsSure()) return short_.mean_s + short_.step_s * place_;
  return std::lerp(short_.At(place_), long_.At(place_), share_of_long_);
}

}  // namespace gyrobench::calibration
