// HTTP over a Unix socket: the transport of the control API, and nothing of its meaning.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "daemon/access.h"

namespace gyrobench::daemon {

struct HttpRequest {
  std::string method;  // GET, POST
  std::string path;    // /v1/status
  std::string body;
  // What Lanes::stamp said when it had been read; nullopt where it has not waited.
  std::optional<std::int64_t> stamp = {};
  std::optional<Peer> peer = {};  // who asks; nullopt within the daemon
};

struct HttpReply {
  unsigned status = 200;
  std::string body;  // JSON
};

// Whose the socket is, and with which permissions. Without an owner or a group it is the daemon's;
// only root may give it to another owner.
struct SocketRights {
  unsigned mode = 0660;
  std::optional<std::string> owner = {}, group = {};
};

// Throws Error where something else than a socket is in its place: no file of anybody's is removed.
void RequireSocketOrNothing(const std::filesystem::path& socket);

// Serves in threads of its own until destroyed. A client that sends nothing for 10 s, or a body of
// more than 64 kB, is dropped; where too many are connected, the one that has been idle for longest
// is.
class ControlServer {
 public:
  // What it throws is answered with 500.
  using Handler = std::function<HttpReply(const HttpRequest&)>;
  // Requests of one lane are handled one at a time, in a thread of the lane's own, and wait for no
  // other lane; where too many wait, the next are answered with 503.
  struct Lanes {
    std::size_t count = 1;
    std::function<std::size_t(const HttpRequest&)> of;  // below count
    // Asked before a request waits in its lane: so it can be told from what came after others were
    // answered. May be empty.
    std::function<std::int64_t()> stamp = {};
    // The first so many hang where one request takes them long; the others may.
    std::size_t quick = 0;
  };
  // Creates `socket` with these rights, in a folder that is created if need be. Takes
  // over a socket that a dead daemon left; throws Error when a live one holds it, when something
  // else than a socket is in its place, or when it cannot be made.
  ControlServer(const std::filesystem::path& socket, const SocketRights& rights, Handler handler,
                Lanes lanes);
  // One lane for all.
  ControlServer(const std::filesystem::path& socket, const SocketRights& rights, Handler handler);
  ~ControlServer();
  // The thread that has been at one thing for longer than `longest_s`, in words; empty where there is
  // none.
  std::string Stuck(double longest_s = kLongest_s) const;

 private:
  static constexpr double kLongest_s = 30.0;
  class Listener;
  std::unique_ptr<Listener> listener_;
};

}  // namespace gyrobench::daemon
