// What whoever comes to the stand is to know, though nothing is broken: what was found at the
// start, and what was done about it.
#pragma once

#include <spdlog/spdlog.h>

#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"

namespace gyrobench::daemon {

struct Notice {
  Utime utime = 0;
  std::string text;
};

// In the log at once, and in the status until a reset. Thread-safe.
class Notices {
 public:
  // The oldest are kept: the first is nearest to the cause.
  static constexpr std::size_t kMost = 100;

  void Add(Utime utime, std::string text) {
    spdlog::warn("{}", text);
    const std::lock_guard lock(mutex_);
    if (list_.size() < kMost) list_.push_back({utime, std::move(text)});
  }
  std::vector<Notice> List() const {
    const std::lock_guard lock(mutex_);
    return list_;
  }
  void Clear() {
    const std::lock_guard lock(mutex_);
    list_.clear();
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Notice> list_;
};

}  // namespace gyrobench::daemon
