#include "calibration/signal/packet_stamps.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace gyrobench::calibration {
namespace {

constexpr double kSureFrom = 64.0;  // stamps
constexpr double kLineMemory_s = 20.0;
constexpr double kLongestSilence_s = 2.0;
// Standard deviations about the line. What is later came after a pause of the host, and says
// nothing of the clock; what stays so does.
constexpr double kLatest = 3.0;
constexpr double kLongestWait_s = 1.0;

}  // namespace

double PacketStamps::TimeOf(double stamp_s, bool of_other_axes) {
  if (!std::isfinite(stamp_s)) return stamp_s;
  const double step_s = stamp_s - last_stamp_s_;
  last_stamp_s_ = stamp_s;
  wrong_since_s_ = kMissing;
  const bool goes_on = step_s >= 0.0 && step_s <= kLongestSilence_s;
  if (goes_on) watch_.Take(step_s, of_other_axes);
  if (!goes_on || !watch_.in_packets() || !on_) {
    on_ = watch_.in_packets();
    if (on_) Begin(stamp_s);
    return last_s_ = stamp_s;
  }
  if (watch_.BeginsPacket(step_s)) {
    EndPacket();
    packet_begin_s_ = stamp_s;
  }
  packet_end_s_ = stamp_s;
  Add(stamp_s, std::max(kLineMemory_s / watch_.mean_step_s(), kSureFrom));
  ++on_line_;
  return last_s_ = std::max(first_s_ + LineAt(), JustAfter(last_s_));
}

// The clock goes on as it was, from another time on.
void PacketStamps::Begin(double stamp_s) {
  const double step_s = LineIsSure() ? line_.slope_s() : watch_.mean_step_s();
  first_s_ = stamp_s;
  count_ = 1;
  place_ = late_s_ = 0.0;
  line_ = {};
  line_.step_s = step_s;
  samples_ = packets_ = windows_ = 0;
  packet_begin_s_ = packet_end_s_ = stamp_s;
  window_before_s_ = window_s_ = stamp_s;
}

void PacketStamps::Add(double stamp_s, double memory) {
  ++count_;
  ++samples_;
  place_ += 1.0;
  double since_first_s = stamp_s - first_s_;
  if (LineIsSure()) {
    late_s_ = since_first_s - LineAt();
    interval_s_ = line_.slope_s();
    scatter_s_ = std::sqrt(std::max(line_.left_s2(), 0.0));
    const double latest_s = LineAt() + kLatest * scatter_s_;
    late_in_a_row_ = since_first_s > latest_s ? late_in_a_row_ + 1 : 0;
    if (late_in_a_row_ > 0 && static_cast<double>(late_in_a_row_) * interval_s_ < kLongestWait_s)
      return;
    since_first_s = std::min(since_first_s, latest_s);
  }
  line_.Add(place_, since_first_s, memory);
  if (LineIsSure() && std::has_single_bit(static_cast<std::uint64_t>(count_)))
    line_.MakeStepsItsOwn();
}

// The last sample of a packet is late by less than an interval, and what reading it takes. Samples
// that are lost make it later by as many intervals. After a pause of the host it is not, for all
// that waited come at once.
void PacketStamps::EndPacket() {
  constexpr std::int64_t kInWindow = 32, kPackets = 4, kUsualWindows = 8;
  // Intervals, and of a packet; of single ones over a window, where an interval does not drown in
  // what the host takes.
  constexpr double kSurelyLost = 1.5, kOfPacket = 0.5, kLostShare = 0.7, kSeenFrom_s = 4e-3;
  if (!LineIsSure()) return;
  const double late_s = late_s_ - (packet_end_s_ - packet_begin_s_);
  const double beyond_s = late_s - usual_least_s_;
  const double most_s = kSurelyLost * interval_s_ + kOfPacket * watch_.packet_s();
  if (windows_ == kUsualWindows && std::fabs(beyond_s) > most_s) return Skip(beyond_s);
  least_late_s_ = packets_ == 0 ? late_s : std::min(least_late_s_, late_s);
  if (++packets_ < kPackets || samples_ < kInWindow) return;
  const double beyond_of_all_s = least_late_s_ - usual_least_s_;
  if (windows_ == kUsualWindows && interval_s_ > kSeenFrom_s &&
      std::fabs(beyond_of_all_s) > kLostShare * interval_s_)
    return Skip(beyond_of_all_s);
  samples_ = packets_ = 0;
  window_before_s_ = window_s_;
  window_s_ = last_s_;
  windows_ = std::min(windows_ + 1, kUsualWindows);
  usual_least_s_ += (least_late_s_ - usual_least_s_) / static_cast<double>(windows_);
}

// From somewhere in the window before on the times were off by as much.
void PacketStamps::Skip(double beyond_s) {
  const double lost = std::round(beyond_s / interval_s_);
  place_ += lost;
  lost_ += static_cast<std::int64_t>(lost);
  wrong_since_s_ = window_before_s_;
  samples_ = packets_ = 0;
  window_before_s_ = window_s_ = last_s_;
}

bool PacketStamps::LineIsSure() const { return static_cast<double>(count_) >= kSureFrom; }

double PacketStamps::LineAt() const {
  return LineIsSure() ? line_.At(place_) : line_.mean_s + line_.step_s * place_;
}

}  // namespace gyrobench::calibration
