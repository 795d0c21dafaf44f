// A machine that makes no more threads, for tests of who goes on without.
#pragma once

namespace gyrobench::daemon {

// While one lives, the thread that made it gets no other. One at a time in a thread.
class NoThreads {
 public:
  NoThreads();
  ~NoThreads();
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;
};

}  // namespace gyrobench::daemon
