// Loaded before the C library (LD_PRELOAD): a disk that hangs for as long as the file exists that
// GYROBENCH_STALLED names. For tests of a whole daemon; within one program there is
// tests/daemon/slow_disk.h.
#include <sys/syscall.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <thread>

namespace {

void AwaitDisk() {
  const char* const stalled = std::getenv("GYROBENCH_STALLED");
  while (stalled != nullptr && access(stalled, F_OK) == 0) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace

extern "C" int fdatasync(int file) {
  AwaitDisk();
  return static_cast<int>(syscall(SYS_fdatasync, file));
}

extern "C" ssize_t pwrite(int file, const void* data, size_t size, off_t place) {
  AwaitDisk();
  return syscall(SYS_pwrite64, file, data, size, place);
}
