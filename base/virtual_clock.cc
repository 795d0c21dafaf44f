#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>
#include <vector>

#include "base/clock.h"

namespace gyrobench {
namespace {

using std::chrono::steady_clock;

class VirtualClockImpl final : public VirtualClock {
 public:
  explicit VirtualClockImpl(Utime start) : now_(start), anchor_virtual_(start) {}

  Utime Now() const override {
    const std::lock_guard lock(mutex_);
    return now_;
  }

  std::unique_ptr<Participant> Join(std::string /*name*/, Role role) override;

  std::int64_t RealTimeout(std::int64_t timeout_us) const override {
    constexpr std::int64_t kPatience = 2 * kMicrosecondsPerSecond;
    return std::max(timeout_us, kPatience);
  }

  void SetPace(double pace) override {
    const std::lock_guard lock(mutex_);
    pace_ = pace;
    Anchor();
    if (running_ <= 0) Advance();
  }

 private:
  class VirtualParticipant;

  // The functions below are called with mutex_ held.
  void Anchor() {
    anchor_real_ = steady_clock::now();
    anchor_virtual_ = now_;
  }
  bool Paced() const { return pace_ < kUnpaced; }
  // Real time at which paced virtual time reaches `wake_up`.
  steady_clock::time_point RealTimeOf(Utime wake_up) const {
    constexpr double kDay_s = 86400.0;
    if (wake_up == kForever) return anchor_real_ + std::chrono::hours(24 * 365);
    const double ahead_s =
        pace_ > 0 ? std::min(kDay_s, ToSeconds(wake_up - anchor_virtual_) / pace_) : kDay_s;
    return anchor_real_ + std::chrono::duration_cast<steady_clock::duration>(
                              std::chrono::duration<double>(ahead_s));
  }
  VirtualParticipant* Earliest() const;
  void Advance();
  void Release(VirtualParticipant& chosen);

  mutable std::mutex mutex_;
  Utime now_;
  int running_ = 0;  // below 0 while a resident and its guest wait on one count, see Advance
  std::int64_t joined_ = 0;
  std::vector<VirtualParticipant*> waiting_;
  double pace_ = kUnpaced;
  Utime anchor_virtual_;
  steady_clock::time_point anchor_real_ = steady_clock::now();
};

class VirtualClockImpl::VirtualParticipant final : public Participant {
 public:
  VirtualParticipant(VirtualClockImpl& clock, bool resident) : clock_(clock), resident_(resident) {}

  ~VirtualParticipant() override {
    if (!resident_) return;
    const std::lock_guard lock(clock_.mutex_);
    if (--clock_.running_ <= 0) clock_.Advance();
  }

  bool WaitUntil(Utime wake_up) override {
    std::unique_lock lock(clock_.mutex_);
    if (notified_) {
      notified_ = false;
      return true;
    }
    wake_up_ = std::max(wake_up, clock_.now_);
    released_ = false;
    clock_.waiting_.push_back(this);
    if (--clock_.running_ <= 0) clock_.Advance();
    while (!released_) {
      if (!clock_.Paced()) {
        condition_.wait(lock);
        continue;
      }
      const auto due = clock_.RealTimeOf(wake_up_);
      if (condition_.wait_until(lock, due) == std::cv_status::timeout && clock_.running_ <= 0) {
        clock_.Advance();
      }
      // Another is due at the same moment and runs first; its next wait advances time to us.
      if (!released_ && clock_.running_ > 0) condition_.wait(lock);
    }
    return std::exchange(notified_, false);
  }

  void Notify() override {
    const std::lock_guard lock(clock_.mutex_);
    notified_ = true;
    if (released_) return;
    wake_up_ = clock_.now_;
    if (clock_.running_ <= 0) clock_.Advance();
  }

 private:
  friend class VirtualClockImpl;
  VirtualClockImpl& clock_;
  const bool resident_;
  std::int64_t order_ = 0;
  Utime wake_up_ = 0;
  bool released_ = true;
  bool notified_ = false;
  std::condition_variable condition_;
};

std::unique_ptr<Clock::Participant> VirtualClockImpl::Join(std::string /*name*/, Role role) {
  const std::lock_guard lock(mutex_);
  const bool resident = role == Role::kResident;
  auto participant = std::make_unique<VirtualParticipant>(*this, resident);
  participant->order_ = joined_++;
  if (resident) ++running_;
  return participant;
}

VirtualClockImpl::VirtualParticipant* VirtualClockImpl::Earliest() const {
  VirtualParticipant* best = nullptr;
  for (VirtualParticipant* waiting : waiting_) {
    if (best == nullptr || waiting->wake_up_ < best->wake_up_ ||
        (waiting->wake_up_ == best->wake_up_ && waiting->order_ < best->order_)) {
      best = waiting;
    }
  }
  return best;
}

// All wait: release the earliest, if its time has come. Paced time comes by itself: every waiter
// holds a real deadline, and the first to pass it calls here.
void VirtualClockImpl::Advance() {
  // More than one is released only after a resident gave up waiting for its guest (a call that
  // blocked outside the clock timed out) and waits itself: then both wait on one count.
  while (running_ <= 0) {
    VirtualParticipant* next = Earliest();
    if (next == nullptr || next->wake_up_ == kForever) return;
    if (Paced() && next->wake_up_ > now_ && steady_clock::now() < RealTimeOf(next->wake_up_)) {
      next->condition_.notify_one();  // its deadline may be news to it
      return;
    }
    Release(*next);
  }
}

void VirtualClockImpl::Release(VirtualParticipant& chosen) {
  now_ = std::max(now_, chosen.wake_up_);
  waiting_.erase(std::find(waiting_.begin(), waiting_.end(), &chosen));
  chosen.released_ = true;
  ++running_;
  chosen.condition_.notify_one();
}

}  // namespace

std::unique_ptr<VirtualClock> MakeVirtualClock(Utime start) {
  return std::make_unique<VirtualClockImpl>(start);
}

}  // namespace gyrobench
