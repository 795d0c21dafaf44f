// A disk that takes its time, or is full, for tests of who waits for it.
#pragma once

#include <cstdint>
#include <functional>

namespace gyrobench::daemon {

// While one lives, `during` is called whenever a file of this process is being written at its
// place, looked up by its name or synced, in the thread that does so. One at a time.
class SlowDisk {
 public:
  explicit SlowDisk(std::function<void()> during);
  ~SlowDisk();
  SlowDisk(const SlowDisk&) = delete;
  SlowDisk& operator=(const SlowDisk&) = delete;
};

// While one lives, so many bytes are free on every disk.
class LittleRoom {
 public:
  explicit LittleRoom(std::int64_t bytes);
  ~LittleRoom();
  LittleRoom(const LittleRoom&) = delete;
  LittleRoom& operator=(const LittleRoom&) = delete;
};

}  // namespace gyrobench::daemon
