// Ctrl-C as something to wait for, next to sockets, instead of a handler.
#pragma once

#include <signal.h>

namespace gyrobench::cli {

// While it lives SIGINT does not end the program but makes descriptor() readable. To be made before
// other threads start: they inherit what is blocked.
class InterruptWatch {
 public:
  // Throws Error when the kernel gives no descriptor.
  InterruptWatch();
  ~InterruptWatch();
  InterruptWatch(const InterruptWatch&) = delete;
  InterruptWatch& operator=(const InterruptWatch&) = delete;

  int descriptor() const { return descriptor_; }
  // True when Ctrl-C came since the last call.
  bool Take();
  // Throws Error, "stopped by Ctrl-C: ..." with what is left then, where it came since the last call.
  void ThrowIfAsked(const char* left);

 private:
  sigset_t before_{};
  int descriptor_ = -1;
};

}  // namespace gyrobench::cli
