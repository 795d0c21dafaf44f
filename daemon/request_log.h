// Who asked for what over the control socket, in the log.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "daemon/access.h"

namespace gyrobench::daemon {

// Written in a thread of its own: the name of a user may have to be asked of a directory service,
// which may hang, and nobody who asks for a stop waits for it.
class RequestLog {
 public:
  // Of a peer, in that thread.
  using Name = std::function<std::string(const Peer&)>;

  RequestLog();  // NameOf and 3 s
  RequestLog(Name name_of, std::chrono::milliseconds last_patience);
  // What waits is written first. A thread that hangs for longer than the last patience is left to
  // itself, and writes nothing any more.
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
  const std::chrono::milliseconds last_patience_;
  std::thread thread_;
};

}  // namespace gyrobench::daemon
