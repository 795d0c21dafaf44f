#include "daemon/plain_log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <string_view>

#include "presentation/markup.h"

namespace gyrobench::daemon {
namespace {

// The message, line by line.
class PlainMessage final : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message, const std::tm& /*time*/,
              spdlog::memory_buf_t& to) override {
    std::string_view rest(message.payload.data(), message.payload.size());
    for (;;) {
      const std::size_t end = rest.find('\n');
      const std::string line = presentation::CleanText(rest.substr(0, end));
      to.append(line.data(), line.data() + line.size());
      if (end == std::string_view::npos) return;
      to.push_back('\n');
      rest.remove_prefix(end + 1);
    }
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
