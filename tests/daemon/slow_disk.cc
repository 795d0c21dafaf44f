#include "tests/daemon/slow_disk.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <mutex>
#include <utility>

namespace {

std::mutex mutex;  // guards the next
std::function<void()> during_work;

void Work() {
  std::function<void()> during;
  {
    const std::lock_guard lock(mutex);
    during = during_work;
  }
  if (during) during();
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
  return fstatat(AT_FDCWD, path, status, 0);
}

namespace gyrobench::daemon {

SlowDisk::SlowDisk(std::function<void()> during) {
  const std::lock_guard lock(mutex);
  during_work = std::move(during);
}

SlowDisk::~SlowDisk() {
  const std::lock_guard lock(mutex);
  during_work = nullptr;
}

}  // namespace gyrobench::daemon
