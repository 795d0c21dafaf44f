#include "daemon/daemon_log.h"

#include <pthread.h>
#include <spdlog/async.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <ctime>
#include <future>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "presentation/markup.h"

namespace gyrobench::daemon {
namespace {

constexpr std::chrono::seconds kLastPatience{3};

class PlainMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& to) override {
    const std::string clean =
        presentation::CleanLines({message.payload.data(), message.payload.size()});
    to.append(clean.data(), clean.data() + clean.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<PlainMessage>();
  }
};

}  // namespace

DaemonLog::DaemonLog() {
  spdlog::init_thread_pool(kMostUnwritten, 1, [] { pthread_setname_np(pthread_self(), "log"); });
  spdlog::set_default_logger(std::make_shared<spdlog::async_logger>(
      "gyrobenchd", std::make_shared<spdlog::sinks::stderr_color_sink_mt>(), spdlog::thread_pool(),
      spdlog::async_overflow_policy::overrun_oldest));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PlainMessage>('*').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  spdlog::set_formatter(std::move(formatter));
}

// spdlog waits for its thread without a limit.
bool DaemonLog::Close() {
  if (std::exchange(closed_, true)) return true;
  std::promise<void> written;
  const std::future<void> all = written.get_future();
  std::thread([done = std::move(written)]() mutable {
    spdlog::shutdown();
    done.set_value();
  }).detach();
  return all.wait_for(kLastPatience) == std::future_status::ready;
}

}  // namespace gyrobench::daemon
