// Who asked for what over the control socket, in the log.
#pragma once

#include <memory>
#include <string>
#include <thread>

#include "daemon/access.h"

namespace gyrobench::daemon {

// Written in a thread of its own: the name of a user may have to be asked of a directory service,
// and the log of whoever reads it; either may hang, and nobody who asks for a stop waits for them.
class RequestLog {
 public:
  RequestLog();
  // What waits is written first, but a thread that hangs is not waited for.
  ~RequestLog();
  RequestLog(const RequestLog&) = delete;
  RequestLog& operator=(const RequestLog&) = delete;

  // "alice (process 4711) asked for /v1/stop", and that it was refused where it was. Waits for
  // nobody. Where 100 wait already, the next are counted, and their number is written.
  void Add(const Peer& peer, const std::string& path, unsigned status);

 private:
  struct Shared;
  static void Write(const std::shared_ptr<Shared>& shared);

  const std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace gyrobench::daemon
