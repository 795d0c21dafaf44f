// HTTP over a Unix socket: the transport of the control API, and nothing of its meaning.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

namespace gyrobench::daemon {

struct HttpRequest {
  std::string method;  // GET, POST
  std::string path;    // /v1/status
  std::string body;
};

struct HttpReply {
  unsigned status = 200;
  std::string body;  // JSON
};

// Serves in a thread of its own until destroyed. Requests are handled one at a time; a client that
// sends nothing for 10 s, or a body of more than 64 kB, is dropped.
class ControlServer {
 public:
  using Handler = std::function<HttpReply(const HttpRequest&)>;
  // Creates `socket` with the permissions `mode`, in a folder that is created if need be. Takes
  // over a socket that a dead daemon left; throws Error when a live one holds it, or when it cannot
  // be made.
  ControlServer(const std::filesystem::path& socket, unsigned mode, Handler handler);
  ~ControlServer();

 private:
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace gyrobench::daemon
