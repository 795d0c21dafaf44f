// A disk that takes its time, or is full, for tests of who waits for it.
#pragma once

#include <cstdint>
#include <filesystem>
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

// While one lives, every disk that is asked for its room fails with `error` (errno), so many times.
class FailingDisk {
 public:
  explicit FailingDisk(int error, int times = 1'000'000'000);
  ~FailingDisk();
  FailingDisk(const FailingDisk&) = delete;
  FailingDisk& operator=(const FailingDisk&) = delete;
};

// While one lives, whoever looks up this path gets `error` (errno). One at a time.
class UnreadableFolder {
 public:
  UnreadableFolder(const std::filesystem::path& path, int error);
  ~UnreadableFolder();
  UnreadableFolder(const UnreadableFolder&) = delete;
  UnreadableFolder& operator=(const UnreadableFolder&) = delete;
};

}  // namespace gyrobench::daemon
