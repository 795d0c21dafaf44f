#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <cerrno>
#include <cstring>
#include <limits>
#include <mutex>
#include <utility>

#include "base/error.h"
#include "recording/event_checksum.h"
#include "recording/event_log.h"

namespace gyrobench::recording {

namespace {

// Whoever finds so much unwritten, and nobody writing, writes it: a run on the virtual clock makes
// a record faster than it is synced.
constexpr std::size_t kWriteAt = std::size_t{256} * 1024;
// What memory may hold of a record whose disk hangs: most of an hour at the stand's rates.
constexpr std::size_t kMostPending = std::size_t{64} * 1024 * 1024;
constexpr std::uint32_t kSyncWord = 0xEDA1DA01;

bool IsChannelName(std::string_view channel) {
  return !channel.empty() && channel.size() <= kMaxChannelLength &&
         std::all_of(channel.begin(), channel.end(), [](char c) { return c > ' ' && c < 127; });
}

template <typename Word>
void AppendWord(std::vector<std::uint8_t>& bytes, Word word) {
  const Word big = boost::endian::native_to_big(word);
  const auto* first = reinterpret_cast<const std::uint8_t*>(&big);
  bytes.insert(bytes.end(), first, first + sizeof(big));
}

}  // namespace

struct EventLogWriter::State {
  explicit State(const std::filesystem::path& path) : file(path) {}
  ~State() {
    if (descriptor >= 0) ::close(descriptor);
  }

  // With mutex held. The first failure is the one that is told from then on.
  [[noreturn]] void Fail(std::string message) {
    if (failure.empty()) failure = std::move(message);
    throw DataError(failure);
  }
  [[noreturn]] void FailOfDisk(const std::string& what, const std::string& reason) {
    Fail(fmt::format(
        "{}: {}: {}; {} events recorded, the first {} of them are safe on the disk; free space or "
        "mend the disk, then start the run again",
        file.string(), what, reason, events, synced_events));
  }
  void ThrowIfUnusable() const {
    if (!failure.empty()) throw DataError(failure);
    if (closed) throw DataError(fmt::format("{}: the log is closed", file.string()));
  }
  // With disk_mutex held. What is written to a file without a name is lost when it is closed.
  bool HasItsName() const {
    struct stat opened {
    }, named{};
    if (fstat(descriptor, &opened) != 0) return true;
    const bool there = stat(file.c_str(), &named) == 0;
    return there && named.st_ino == opened.st_ino && named.st_dev == opened.st_dev;
  }
  // With disk_mutex held. Returns the error, 0 if there is none.
  int WriteOut(const std::vector<std::uint8_t>& bytes) {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t n = pwrite(descriptor, bytes.data() + done, bytes.size() - done, size);
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) return n < 0 ? errno : EIO;
      done += static_cast<std::size_t>(n);
      size += n;
    }
    return 0;
  }
  // With disk_mutex held, and mutex not: acquisition goes on while the disk works. Returns how many
  // events the file holds then.
  std::int64_t WritePending() {
    std::int64_t held = 0;
    {
      const std::lock_guard lock(mutex);
      ThrowIfUnusable();
      writing.clear();
      writing.swap(pending);
      held = events;
    }
    const int error = WriteOut(writing);
    if (error == 0) return held;
    const std::lock_guard lock(mutex);
    FailOfDisk("cannot be written", std::strerror(error));
  }

  const std::filesystem::path file;
  std::mutex
      disk_mutex;  // what touches the file; taken before mutex, and never waited for by Write
  int descriptor = -1;
  off_t size = 0;
  std::vector<std::uint8_t> writing;  // kept, so that a write allocates nothing

  mutable std::mutex mutex;  // all below
  std::vector<std::uint8_t> pending;
  std::int64_t events = 0;
  std::int64_t synced_events = 0;
  std::string failure;
  bool closed = false;
};

EventLogWriter::EventLogWriter(const std::filesystem::path& file)
    : state_(std::make_unique<State>(file)) {
  constexpr int kFlags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
  state_->descriptor = ::open(file.c_str(), kFlags, 0666);
  if (state_->descriptor >= 0) return;
  if (errno == EEXIST) {
    throw DataError(fmt::format("{}: exists already; a log is never written over", file.string()));
  }
  throw DataError(fmt::format("{}: cannot be made: {}; choose a records folder that can be written",
                              file.string(), std::strerror(errno)));
}

EventLogWriter::~EventLogWriter() {
  try {
    const std::lock_guard disk(state_->disk_mutex);
    state_->WritePending();
  } catch (const std::exception&) {  // closed, or told already
  }
}

void EventLogWriter::Write(std::string_view channel, Utime utime, const std::uint8_t* data,
                           std::size_t size) {
  State& state = *state_;
  {
    const std::lock_guard lock(state.mutex);
    state.ThrowIfUnusable();
    if (!IsChannelName(channel) || size > kMaxEventData) {
      throw DataError(fmt::format(
          "{}: event of {} bytes on channel '{}' cannot be logged: expected at most {} bytes and a "
          "channel of 1 to {} printable characters",
          state.file.string(), size, channel, kMaxEventData, kMaxChannelLength));
    }
    if (state.pending.size() > kMostPending) {
      state.FailOfDisk("cannot keep up",
                       fmt::format("the disk has yet to take {} MiB", kMostPending >> 20));
    }
    if (state.events > std::numeric_limits<std::uint32_t>::max()) {
      state.FailOfDisk("is full", "a log holds 2^32 events at most");
    }
    const std::size_t begin = state.pending.size();
    AppendWord(state.pending, kSyncWord);
    AppendWord(state.pending, state.events);
    AppendWord(state.pending, static_cast<std::int64_t>(utime));
    AppendWord(state.pending, static_cast<std::int32_t>(channel.size()));
    AppendWord(state.pending, static_cast<std::int32_t>(size));
    state.pending.insert(state.pending.end(), channel.begin(), channel.end());
    state.pending.insert(state.pending.end(), data, data + size);
    std::uint8_t* event = state.pending.data() + begin;
    boost::endian::store_big_u32(event + kEventNumberAt,
                                 EventChecksum(event, state.pending.size() - begin));
    ++state.events;
    if (state.pending.size() < kWriteAt) return;
  }
  if (const std::unique_lock disk(state.disk_mutex, std::try_to_lock); disk) state.WritePending();
}

void EventLogWriter::Sync() {
  State& state = *state_;
  const std::lock_guard disk(state.disk_mutex);
  const std::int64_t held = state.WritePending();
  const bool named = state.HasItsName();
  const bool synced = fdatasync(state.descriptor) == 0;
  const int error = errno;
  const std::lock_guard lock(state.mutex);
  if (!named) {
    state.Fail(fmt::format(
        "{}: was removed or replaced while it was written; the {} events in it are lost. Leave the "
        "records folder in its place while a run is on, then start the run again",
        state.file.string(), state.events));
  }
  // Pipes and devices cannot be synced, and need not be.
  if (!synced && error != EINVAL && error != EROFS) {
    state.FailOfDisk("cannot be synced", std::strerror(error));
  }
  state.synced_events = held;
}

void EventLogWriter::Close() {
  Sync();
  const std::lock_guard lock(state_->mutex);
  state_->closed = true;
}

std::int64_t EventLogWriter::events() const {
  const std::lock_guard lock(state_->mutex);
  return state_->events;
}

}  // namespace gyrobench::recording
