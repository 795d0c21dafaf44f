#include "tests/daemon/no_threads.h"

#include <dlfcn.h>
#include <pthread.h>

#include <cerrno>

namespace {

thread_local bool none = false;

using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);

}  // namespace

// Takes the place of the C library's in this program.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes,
                              void* (*start)(void*), void* argument) {
  if (none) return EAGAIN;
  static const auto next = reinterpret_cast<Create>(::dlsym(RTLD_NEXT, "pthread_create"));
  return next(thread, attributes, start, argument);
}

namespace gyrobench::daemon {

NoThreads::NoThreads() { none = true; }

NoThreads::~NoThreads() { none = false; }

}  // namespace gyrobench::daemon
