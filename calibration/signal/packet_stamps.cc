#include "calibration/signal/packet_stamps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {
namespace {

constexpr double kStepsInMind = 200.0;
// Of the mean step. Of an adapter that makes packets of 1.2 samples a fifth of the steps are as
// short; of stamps that are late by exponential times of a third of the interval a twentieth.
constexpr double kShortStep = 0.25, kManyShort = 0.15, kFewShort = 0.05;
constexpr double kLeastStamps = 64.0;
constexpr double kLineMemory_s = 20.0;
constexpr double kLongestSilence_s = 2.0;
// Standard deviations about the line. What is later came after a pause of the host.
constexpr double kLatest = 3.0;
// Stamps and packets, of which at least one is hardly late.
constexpr std::int64_t kInWindow = 32, kPacketsInWindow = 4;
constexpr std::int64_t kUsualWindows = 16;
constexpr double kLostShare = 0.7;    // of an interval
constexpr double kSeenFrom_s = 4e-3;  // a shorter interval drowns in what packets are late by
constexpr double kApart_s = 1e-9;

}  // namespace

double PacketStamps::Mend(double stamp_s) {
  if (!std::isfinite(stamp_s)) return stamp_s;
  const double step_s = stamp_s - last_stamp_s_;
  last_stamp_s_ = stamp_s;
  if (count_ == 0 || !(step_s >= 0.0) || step_s > kLongestSilence_s) {
    Begin(stamp_s);
    return last_s_ = stamp_s;
  }
  LookAtStep(step_s);
  Add(stamp_s);
  if (!in_packets_) return last_s_ = stamp_s;
  ++mended_;
  const double after_last_s = std::max(
      last_s_ + kApart_s, std::nextafter(last_s_, std::numeric_limits<double>::infinity()));
  return last_s_ = std::max(first_s_ + LineAt(), after_last_s);
}

double PacketStamps::scatter_s() const {
  return OnLine() ? std::sqrt(std::max(line_.left_s2(), 0.0)) : kMissing;
}

// The clock goes on as it was, from another time on.
void PacketStamps::Begin(double stamp_s) {
  const double step_s = OnLine() ? line_.slope_s() : mean_step_s_;
  first_s_ = stamp_s;
  count_ = 1;
  place_ = 0.0;
  line_ = {};
  line_.step_s = step_s;
  in_window_ = packets_in_window_ = windows_ = 0;
}

void PacketStamps::LookAtStep(double step_s) {
  steps_ = std::min(steps_ + 1.0, kStepsInMind);
  in_a_packet_ = step_s < kShortStep * mean_step_s_;
  mean_step_s_ += (step_s - mean_step_s_) / steps_;
  share_short_ += ((in_a_packet_ ? 1.0 : 0.0) - share_short_) / steps_;
  in_packets_ = steps_ >= kLeastStamps && share_short_ > (in_packets_ ? kFewShort : kManyShort);
}

void PacketStamps::Add(double stamp_s) {
  const double memory = std::max(kLineMemory_s / std::max(mean_step_s_, kApart_s), kLeastStamps);
  ++count_;
  place_ += 1.0;
  double since_first_s = stamp_s - first_s_;
  if (OnLine()) {
    const double late_s = since_first_s - LineAt();
    LookForLost(late_s);
    since_first_s = std::min(since_first_s, LineAt() + kLatest * scatter_s());
  }
  line_.Add(place_, since_first_s, memory);
  if (OnLine() && std::has_single_bit(static_cast<std::uint64_t>(count_))) line_.MakeStepsItsOwn();
}

// Samples that are lost make all that follow late by as many intervals, also the least late of a
// window. A pause of the host does not: all that waited come at once, and the last is hardly late.
void PacketStamps::LookForLost(double late_s) {
  if (!in_a_packet_) ++packets_in_window_;
  if (packets_in_window_ > kPacketsInWindow && in_window_ >= kInWindow) EndWindow();
  least_late_s_ = in_window_ == 0 ? late_s : std::min(least_late_s_, late_s);
  ++in_window_;
}

void PacketStamps::EndWindow() {
  in_window_ = packets_in_window_ = 0;
  const double interval_s = line_.slope_s(), beyond_s = least_late_s_ - usual_least_s_;
  if (windows_ == kUsualWindows && std::fabs(beyond_s) > kLostShare * interval_s &&
      interval_s > kSeenFrom_s) {
    place_ += std::round(beyond_s / interval_s);
    return;
  }
  windows_ = std::min(windows_ + 1, kUsualWindows);
  usual_least_s_ += (least_late_s_ - usual_least_s_) / static_cast<double>(windows_);
}

bool PacketStamps::OnLine() const { return static_cast<double>(count_) >= kLeastStamps; }

double PacketStamps::LineAt() const {
  return OnLine() ? line_.At(place_) : line_.mean_s + line_.step_s * place_;
}

}  // namespace gyrobench::calibration
