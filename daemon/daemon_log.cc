#include "daemon/daemon_log.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <csignal>
#include <cstddef>
#include <ctime>
#include <future>
#include <memory>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#include "presentation/markup.h"

namespace gyrobench::daemon {
namespace {

constexpr std::chrono::seconds kLastPatience{3};

// Of the threads that are started within it: the main thread alone is to see signals.
class SignalsBlocked {
 public:
  SignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~SignalsBlocked() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  SignalsBlocked(const SignalsBlocked&) = delete;
  SignalsBlocked& operator=(const SignalsBlocked&) = delete;

 private:
  sigset_t before_ = {};
};

using Pool = spdlog::details::thread_pool;

// The message as text, and before it how many lines were dropped since the line before.
class PlainMessage final : public spdlog::custom_flag_formatter {
 public:
  // nullptr: nothing is ever dropped. The pool waits for the thread that formats; to ask spdlog for
  // it here, or to hold it, would have that thread wait for the pool as well.
  explicit PlainMessage(Pool* pool) : pool_(pool) {}
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& to) override {
    std::string text = presentation::CleanLines({message.payload.data(), message.payload.size()});
    const std::size_t dropped = pool_ != nullptr ? pool_->overrun_counter() : 0;
    if (dropped > told_) {
      text = fmt::format("({} older lines were dropped: whoever reads the log is too slow) {}",
                         dropped - told_, text);
    }
    told_ = dropped;
    to.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PlainMessage>(pool_);
  }

 private:
  Pool* const pool_;
  std::size_t told_ = 0;
};

std::shared_ptr<spdlog::logger> MakeLogger() {
  constexpr const char* kName = "gyrobenchd";
  const auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
  try {
    const SignalsBlocked blocked;
    spdlog::init_thread_pool(DaemonLog::kMostUnwritten, 1,
                             [] { pthread_setname_np(pthread_self(), "log"); });
  } catch (const std::system_error&) {  // no thread to be had: whoever logs waits for the reader
    return std::make_shared<spdlog::logger>(kName, sink);
  }
  return std::make_shared<spdlog::async_logger>(kName, sink, spdlog::thread_pool(),
                                                spdlog::async_overflow_policy::overrun_oldest);
}

}  // namespace

DaemonLog::DaemonLog() {
  spdlog::set_default_logger(MakeLogger());
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PlainMessage>('*', spdlog::thread_pool().get())
      .set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  spdlog::set_formatter(std::move(formatter));
}

// spdlog waits for its thread without a limit.
bool DaemonLog::Close() {
  if (std::exchange(closed_, true)) return true;
  std::promise<void> written;
  const std::future<void> all = written.get_future();
  try {
    const SignalsBlocked blocked;
    std::thread([done = std::move(written)]() mutable {
      spdlog::shutdown();
      done.set_value();
    }).detach();
  } catch (const std::system_error&) {
    spdlog::shutdown();
    return true;
  }
  return all.wait_for(kLastPatience) == std::future_status::ready;
}

}  // namespace gyrobench::daemon
