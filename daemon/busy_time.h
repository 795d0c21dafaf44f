// How long a thread has been at one thing, seen from outside: a thread that hangs is told by it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

namespace gyrobench::daemon {

// In real time, whatever the bench's clock does. Thread-safe.
class BusyTime {
 public:
  // While it is there, its thread is at something.
  class While {
   public:
    explicit While(BusyTime& time) : time_(time) { time_.since_ns_ = Now_ns(); }
    ~While() { time_.since_ns_ = kAtNothing; }
    While(const While&) = delete;
    While& operator=(const While&) = delete;

   private:
    BusyTime& time_;
  };

  // The thing before is over, and the next one is begun; for threads that are never at nothing.
  void Next() { since_ns_ = Now_ns(); }
  // 0 while it waits for the next.
  double For_s() const {
    const std::int64_t since_ns = since_ns_;
    return since_ns == kAtNothing ? 0.0 : static_cast<double>(Now_ns() - since_ns) * 1e-9;
  }

 private:
  static constexpr std::int64_t kAtNothing = 0;
  static std::int64_t Now_ns() {
    return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
  }

  std::atomic<std::int64_t> since_ns_ = kAtNothing;
};

}  // namespace gyrobench::daemon
