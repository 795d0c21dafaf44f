#include "tests/daemon/slow_names.h"

#include <dlfcn.h>
#include <grp.h>
#include <pwd.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include <mutex>
#include <utility>

namespace {

std::mutex names_mutex;  // guards the next
std::function<void()> during_lookup;

void LookUp() {
  std::function<void()> during;
  {
    const std::lock_guard lock(names_mutex);
    during = during_lookup;
  }
  if (during) during();
}

}  // namespace

// These take the place of the C library's in this program.
extern "C" int getpwuid_r(uid_t user_id, passwd* entry, char* text, size_t size, passwd** found) {
  LookUp();
  static const auto next =
      reinterpret_cast<decltype(&::getpwuid_r)>(dlsym(RTLD_NEXT, "getpwuid_r"));
  return next(user_id, entry, text, size, found);
}

extern "C" int getgrouplist(const char* user, gid_t group, gid_t* groups, int* count) {
  LookUp();
  static const auto next =
      reinterpret_cast<decltype(&::getgrouplist)>(dlsym(RTLD_NEXT, "getgrouplist"));
  return next(user, group, groups, count);
}

namespace gyrobench::daemon {

SlowNames::SlowNames(std::function<void()> during) {
  const std::lock_guard lock(names_mutex);
  during_lookup = std::move(during);
}

SlowNames::~SlowNames() {
  const std::lock_guard lock(names_mutex);
  during_lookup = nullptr;
}

LogLines::LogLines() : before_(spdlog::default_logger()) {
  auto logger = std::make_shared<spdlog::logger>(
      "lines", std::make_shared<spdlog::sinks::ostream_sink_mt>(lines_));
  logger->set_pattern("%v");
  spdlog::set_default_logger(std::move(logger));
}

LogLines::~LogLines() { spdlog::set_default_logger(before_); }

}  // namespace gyrobench::daemon
