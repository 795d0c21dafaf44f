#include "cli/interrupt_watch.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.h"

namespace gyrobench::cli {

InterruptWatch::InterruptWatch() {
  sigset_t interrupt;
  sigemptyset(&interrupt);
  sigaddset(&interrupt, SIGINT);
  pthread_sigmask(SIG_BLOCK, &interrupt, &before_);
  descriptor_ = signalfd(-1, &interrupt, SFD_NONBLOCK | SFD_CLOEXEC);
  if (descriptor_ < 0) {
    const int error = errno;
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    throw Error(fmt::format("signalfd: {}: Ctrl-C could not be watched", std::strerror(error)));
  }
}

InterruptWatch::~InterruptWatch() {
  close(descriptor_);
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool InterruptWatch::Take() {
  signalfd_siginfo info{};
  return read(descriptor_, &info, sizeof(info)) == static_cast<ssize_t>(sizeof(info));
}

void InterruptWatch::ThrowIfAsked(const char* left) {
  if (Take()) throw Error(fmt::format("stopped by Ctrl-C: {}", left));
}

}  // namespace gyrobench::cli
