#include "daemon/plain_log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <string>

#include "presentation/markup.h"

namespace gyrobench::daemon {
namespace {

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

void UsePlainLog() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("gyrobenchd"));
  auto formatter = std::make_unique<spdlog::pattern_formatter>();
  formatter->add_flag<PlainMessage>('*').set_pattern("[%Y-%m-%d %H:%M:%S.%e] [%n] [%^%l%$] %*");
  spdlog::set_formatter(std::move(formatter));
}

}  // namespace gyrobench::daemon
