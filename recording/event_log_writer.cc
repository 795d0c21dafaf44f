#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <mutex>

#include "base/error.h"
#include "recording/event_log.h"

namespace gyrobench::recording {

namespace {

constexpr std::size_t kFileBuffer = std::size_t{256} * 1024;

bool IsChannelName(std::string_view channel) {
  return !channel.empty() && channel.size() <= kMaxChannelLength &&
         std::all_of(channel.begin(), channel.end(), [](char c) { return c > ' ' && c < 127; });
}

}  // namespace

struct EventLogWriter::State {
  explicit State(const std::filesystem::path& path) : file(path) {}

  // With mutex held. The first failure is the one that is told from then on.
  [[noreturn]] void Fail(const std::string& what, int error) {
    failure = fmt::format(
        "{}: {}: {}; {} events written, the first {} of them are safe on the disk; free space or "
        "mend the disk, "
        "then start the run again",
        file.string(), what, std::strerror(error), events, synced_events);
    throw DataError(failure);
  }
  // The same, where what was written has no name any more.
  [[noreturn]] void FailWithoutName() {
    failure = fmt::format(
        "{}: was removed or replaced while it was written; the {} events in it are lost. Leave the "
        "records folder in its place while a run is on, then start the run again",
        file.string(), events);
    throw DataError(failure);
  }
  // With mutex held. What is written to a file without a name is lost when it is closed.
  void RequireName() {
    struct stat opened {
    }, named{};
    if (fstat(fileno(log->getFilePtr()), &opened) != 0) return;
    const bool there = stat(file.c_str(), &named) == 0;
    if (there && named.st_ino == opened.st_ino && named.st_dev == opened.st_dev) return;
    FailWithoutName();
  }
  void ThrowIfUnusable() const {
    if (!failure.empty()) throw DataError(failure);
    if (!log) throw DataError(fmt::format("{}: the log is closed", file.string()));
  }

  std::filesystem::path file;
  mutable std::mutex mutex;  // the log and all below
  std::mutex sync_mutex;     // taken before mutex; keeps the descriptor open during fdatasync
  std::unique_ptr<lcm::LogFile> log;
  lcm::LogEvent event;  // reused, so that a write allocates nothing
  std::int64_t events = 0;
  std::int64_t synced_events = 0;
  std::string failure;
};

EventLogWriter::EventLogWriter(const std::filesystem::path& file)
    : state_(std::make_unique<State>(file)) {
  if (std::filesystem::exists(file)) {
    throw DataError(fmt::format("{}: exists already; a log is never written over", file.string()));
  }
  errno = 0;
  state_->log = std::make_unique<lcm::LogFile>(file.string(), "w");
  if (!state_->log->good()) {
    throw DataError(
        fmt::format("{}: cannot be made: {}; choose a records folder that can be written",
                    file.string(), std::strerror(errno)));
  }
  std::setvbuf(state_->log->getFilePtr(), nullptr, _IOFBF, kFileBuffer);
}

EventLogWriter::~EventLogWriter() = default;

void EventLogWriter::Write(std::string_view channel, Utime utime, const std::uint8_t* data,
                           std::size_t size) {
  State& state = *state_;
  const std::lock_guard lock(state.mutex);
  state.ThrowIfUnusable();
  if (!IsChannelName(channel) || size > kMaxEventData) {
    throw DataError(fmt::format(
        "{}: event of {} bytes on channel '{}' cannot be logged: expected at most {} bytes and a "
        "channel of 1 to {} printable characters",
        state.file.string(), size, channel, kMaxEventData, kMaxChannelLength));
  }
  state.event.channel.assign(channel);
  state.event.timestamp = utime;
  state.event.datalen = static_cast<std::int32_t>(size);
  // LCM's writer takes a plain pointer and only reads from it.
  state.event.data = const_cast<std::uint8_t*>(data);
  errno = 0;
  if (state.log->writeEvent(&state.event) != 0) state.Fail("cannot be written", errno);
  ++state.events;
}

void EventLogWriter::Sync() {
  State& state = *state_;
  const std::lock_guard sync_lock(state.sync_mutex);
  int descriptor = -1;
  std::int64_t flushed = 0;
  {
    const std::lock_guard lock(state.mutex);
    state.ThrowIfUnusable();
    errno = 0;
    if (std::fflush(state.log->getFilePtr()) != 0) state.Fail("cannot be written", errno);
    state.RequireName();
    descriptor = fileno(state.log->getFilePtr());
    flushed = state.events;
  }
  // Outside the lock: acquisition goes on while the disk works.
  const bool synced = fdatasync(descriptor) == 0;
  const int error = errno;
  const std::lock_guard lock(state.mutex);
  // Pipes and devices cannot be synced, and need not be.
  if (!synced && error != EINVAL && error != EROFS) state.Fail("cannot be synced", error);
  state.synced_events = flushed;
}

void EventLogWriter::Close() {
  Sync();
  const std::lock_guard sync_lock(state_->sync_mutex);
  const std::lock_guard lock(state_->mutex);
  state_->log.reset();
}

std::int64_t EventLogWriter::events() const {
  const std::lock_guard lock(state_->mutex);
  return state_->events;
}

}  // namespace gyrobench::recording
