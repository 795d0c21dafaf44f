#include "tests/daemon/slow_disk.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <mutex>
#include <string>
#include <utility>

namespace {

std::mutex mutex;  // guards the next
std::function<void()> during_work;
std::string unreadable;  // this one too
std::atomic<int> unreadable_error = 0;
std::atomic<std::int64_t> room_bytes = -1;  // as it is
std::atomic<int> room_error = 0, room_failures = 0;

void Work() {
  std::function<void()> during;
  {
    const std::lock_guard lock(mutex);
    during = during_work;
  }
  if (during) during();
}

bool IsUnreadable(const char* path) {
  const std::lock_guard lock(mutex);
  return unreadable_error != 0 && unreadable == path;
}

}  // namespace

// These take the place of the C library's in this program; the data of a test need not be safe.
extern "C" int fdatasync(int) {
  Work();
  return 0;
}

extern "C" ssize_t pwrite(int file, const void* data, size_t size, off_t place) {
  Work();
  return syscall(SYS_pwrite64, file, data, size, place);
}

extern "C" int stat(const char* path, struct stat* status) {
  Work();
  if (IsUnreadable(path)) {
    errno = unreadable_error;
    return -1;
  }
  return fstatat(AT_FDCWD, path, status, 0);
}

extern "C" int statvfs(const char* path, struct statvfs* status) {
  if (room_failures > 0) {
    --room_failures;
    errno = room_error;
    return -1;
  }
  struct statfs all {};
  if (statfs(path, &all) != 0) return -1;
  *status = {};
  status->f_bsize = status->f_frsize = static_cast<unsigned long>(all.f_bsize);
  status->f_blocks = all.f_blocks;
  status->f_bfree = all.f_bfree;
  const std::int64_t room = room_bytes;
  status->f_bavail = room < 0 ? all.f_bavail : static_cast<fsblkcnt_t>(room / all.f_bsize);
  return 0;
}

namespace gyrobench::daemon {

LittleRoom::LittleRoom(std::int64_t bytes) { room_bytes = bytes; }

LittleRoom::~LittleRoom() { room_bytes = -1; }

FailingDisk::FailingDisk(int error, int times) {
  room_error = error;
  room_failures = times;
}

FailingDisk::~FailingDisk() { room_failures = 0; }

UnreadableFolder::UnreadableFolder(const std::filesystem::path& path, int error) {
  const std::lock_guard lock(mutex);
  unreadable = path.string();
  unreadable_error = error;
}

UnreadableFolder::~UnreadableFolder() { unreadable_error = 0; }

SlowDisk::SlowDisk(std::function<void()> during) {
  const std::lock_guard lock(mutex);
  during_work = std::move(during);
}

SlowDisk::~SlowDisk() {
  const std::lock_guard lock(mutex);
  during_work = nullptr;
}

}  // namespace gyrobench::daemon
