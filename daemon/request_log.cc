#include "daemon/request_log.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <mutex>
#include <utility>

namespace gyrobench::daemon {
namespace {

constexpr std::size_t kMostUnwritten = 100;
constexpr unsigned kRefused = 400, kForbidden = 403;

struct Asked {
  Peer peer;
  std::string path;
  unsigned status = 0;
};

std::string SentenceOf(const Asked& asked, const std::string& name) {
  std::string sentence = fmt::format("{} asked for {}", name, asked.path);
  if (asked.status == kForbidden) return sentence + " and may not move the stand";
  if (asked.status >= kRefused) return fmt::format("{}: refused ({})", sentence, asked.status);
  return sentence;
}

}  // namespace

// Outlives the log where its thread hangs.
struct RequestLog::Shared {
  explicit Shared(Name name) : name_of(std::move(name)) {}
  const Name name_of;
  std::mutex mutex;  // guards what follows; not held while a name is looked up
  std::condition_variable changed;
  std::deque<Asked> unwritten;
  std::size_t unlisted = 0;  // how many found no room
  bool ending = false;
  bool ended = false;      // by the thread
  bool abandoned = false;  // nobody waits for it any more
};

RequestLog::RequestLog()
    : RequestLog([](const Peer& peer) { return NameOf(peer); }, std::chrono::seconds(3)) {}

RequestLog::RequestLog(Name name_of, std::chrono::milliseconds last_patience)
    : shared_(std::make_shared<Shared>(std::move(name_of))),
      last_patience_(last_patience),
      thread_([shared = shared_] { Write(shared); }) {}

RequestLog::~RequestLog() {
  std::unique_lock lock(shared_->mutex);
  shared_->ending = true;
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, last_patience_, [this] { return shared_->ended; });
  const bool hangs = !shared_->ended;
  shared_->abandoned = hangs;
  lock.unlock();
  if (hangs) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void RequestLog::Add(const Peer& peer, const std::string& path, unsigned status) {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->unwritten.size() >= kMostUnwritten) {
    ++shared_->unlisted;
    return;
  }
  shared_->unwritten.push_back({peer, path, status});
  shared_->changed.notify_all();
}

void RequestLog::Write(const std::shared_ptr<Shared>& shared) {
  std::unique_lock lock(shared->mutex);
  for (;;) {
    shared->changed.wait(lock, [&] { return shared->ending || !shared->unwritten.empty(); });
    if (shared->unwritten.empty()) break;
    const Asked asked = std::move(shared->unwritten.front());
    shared->unwritten.pop_front();
    const std::size_t unlisted = std::exchange(shared->unlisted, 0);
    lock.unlock();
    const std::string sentence = SentenceOf(asked, shared->name_of(asked.peer));
    lock.lock();
    // Once abandoned, the log may be closed.
    if (shared->abandoned) return;
    spdlog::log(asked.status == kForbidden ? spdlog::level::warn : spdlog::level::info, "{}",
                sentence);
    if (unlisted > 0) {
      spdlog::warn("{} more requests came while this one was being written, and are not listed",
                   unlisted);
    }
  }
  shared->ended = true;
  shared->changed.notify_all();
}

}  // namespace gyrobench::daemon
