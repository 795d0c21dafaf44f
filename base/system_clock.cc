#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "base/clock.h"

namespace gyrobench {
namespace {

using std::chrono::duration_cast;
using std::chrono::microseconds;
using std::chrono::steady_clock;
using std::chrono::system_clock;

class SystemClock final : public Clock {
 public:
  Utime Now() const override {
    return start_ + duration_cast<microseconds>(steady_clock::now() - steady_start_).count();
  }

  std::unique_ptr<Participant> Join(std::string /*name*/, Role /*role*/) override {
    return std::make_unique<SystemParticipant>(*this);
  }

  std::int64_t RealTimeout(std::int64_t timeout_us) const override { return timeout_us; }

 private:
  class SystemParticipant final : public Participant {
   public:
    explicit SystemParticipant(const SystemClock& clock) : clock_(clock) {}

    bool WaitUntil(Utime wake_up) override {
      std::unique_lock lock(mutex_);
      if (wake_up == kForever) {
        condition_.wait(lock, [&] { return notified_; });
      } else {
        const auto deadline = clock_.steady_start_ + microseconds(wake_up - clock_.start_);
        condition_.wait_until(lock, deadline, [&] { return notified_; });
      }
      return std::exchange(notified_, false);
    }

    void Notify() override {
      {
        const std::lock_guard lock(mutex_);
        notified_ = true;
      }
      condition_.notify_one();
    }

   private:
    const SystemClock& clock_;
    std::mutex mutex_;
    std::condition_variable condition_;
    bool notified_ = false;
  };

  const steady_clock::time_point steady_start_ = steady_clock::now();
  const Utime start_ = duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
};

}  // namespace

std::unique_ptr<Clock> MakeSystemClock() { return std::make_unique<SystemClock>(); }

}  // namespace gyrobench
