// Who asks over the control socket, and who may move the stand.
#pragma once

#include <sys/types.h>

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace gyrobench::daemon {

// The process at the other end of a connection, as the kernel knows it (unix(7), SO_PEERCRED).
struct Peer {
  pid_t process = 0;
  uid_t user_id = 0;
  gid_t group_id = 0;
};

// "alice (process 4711)"; the number of a user who has no name here.
std::string NameOf(const Peer& peer);

// What the other end of a connected Unix socket is. Throws Error where the kernel does not say.
Peer PeerOf(int socket);

class Access {
 public:
  // `movers`: names of users, and of groups behind "@". Without any, everybody who can connect may
  // move the stand. Throws Error with the name that this machine does not know.
  explicit Access(const std::vector<std::string>& movers);

  // Root and the daemon's own user may always; so may what comes from the daemon itself, without a
  // peer. A user is of a group by the machine's list of its members or as the process's own.
  bool MayMove(const std::optional<Peer>& peer) const;
  // "alice, @lab".
  const std::string& movers() const { return text_; }

 private:
  bool everybody_;
  std::set<uid_t> users_;
  std::set<gid_t> groups_;
  std::string text_;
};

// Numbers of a user and of a group by name. Throw Error where this machine does not know it.
uid_t UserByName(const std::string& name);
gid_t GroupByName(const std::string& name);

}  // namespace gyrobench::daemon
