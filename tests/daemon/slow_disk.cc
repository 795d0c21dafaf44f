#include "tests/daemon/slow_disk.h"

#include <unistd.h>

#include <mutex>
#include <utility>

namespace {

std::mutex mutex;  // guards the next
std::function<void()> during_sync;

}  // namespace

// Takes the place of the C library's in this program; the data of a test need not be safe.
extern "C" int fdatasync(int) {
  std::function<void()> during;
  {
    const std::lock_guard lock(mutex);
    during = during_sync;
  }
  if (during) during();
  return 0;
}

namespace gyrobench::daemon {

SlowDisk::SlowDisk(std::function<void()> during) {
  const std::lock_guard lock(mutex);
  during_sync = std::move(during);
}

SlowDisk::~SlowDisk() {
  const std::lock_guard lock(mutex);
  during_sync = nullptr;
}

}  // namespace gyrobench::daemon
