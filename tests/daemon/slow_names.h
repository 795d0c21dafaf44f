// A list of users that takes its time, and what is logged, for tests of who waits for them.
#pragma once

#include <functional>
#include <memory>
#include <sstream>
#include <string>

namespace spdlog {
class logger;
}

namespace gyrobench::daemon {

// While one lives, `during` is called whenever this process looks up the name or the groups of a
// user, in the thread that does so. One at a time.
class SlowNames {
 public:
  explicit SlowNames(std::function<void()> during);
  ~SlowNames();
  SlowNames(const SlowNames&) = delete;
  SlowNames& operator=(const SlowNames&) = delete;
};

// While one lives, the log is written into it, a line each.
class LogLines {
 public:
  LogLines();
  ~LogLines();
  LogLines(const LogLines&) = delete;
  LogLines& operator=(const LogLines&) = delete;
  // Once no thread logs any more.
  std::string text() const { return lines_.str(); }

 private:
  std::ostringstream lines_;
  std::shared_ptr<spdlog::logger> before_;
};

}  // namespace gyrobench::daemon
