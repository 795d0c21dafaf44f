// A clock that only tests move: a wait ends at once, at the time that was waited for.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "base/clock.h"

namespace gyrobench {

// Where the time of tests begins.
inline constexpr Utime kStart = 1'700'000'000'000'000;

class ManualClock final : public Clock {
 public:
  explicit ManualClock(Utime start = kStart) : now_(start) {}

  Utime Now() const override { return now_; }
  void Advance(Utime duration_us) { now_ += duration_us; }
  std::unique_ptr<Participant> Join(std::string, Role) override {
    return std::make_unique<ManualParticipant>(*this);
  }
  // Real patience for a reply that comes, long enough for a busy machine.
  std::int64_t RealTimeout(std::int64_t) const override { return real_timeout_us; }

  std::int64_t real_timeout_us = 400'000;
  // Called at the start of each wait.
  std::function<void()> on_wait = [] {};

 private:
  class ManualParticipant final : public Participant {
   public:
    explicit ManualParticipant(ManualClock& clock) : clock_(clock) {}
    bool WaitUntil(Utime wake_up) override {
      if (notified_.exchange(false)) return true;
      clock_.on_wait();
      if (clock_.now_ < wake_up) clock_.now_ = wake_up;
      return false;
    }
    void Notify() override { notified_ = true; }

   private:
    ManualClock& clock_;
    std::atomic<bool> notified_ = false;
  };

  std::atomic<Utime> now_;
};

}  // namespace gyrobench
