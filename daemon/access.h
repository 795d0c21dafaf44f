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
  std::vector<gid_t> groups = {};  // the others that it is of
};

// "alice (process 4711)"; the number of a user who has no name here. Asks the machine's list of
// users, which may be elsewhere, and hang: not for threads that others wait for.
std::string NameOf(const Peer& peer);
// "user 1001 (process 4711)". Asks nobody.
std::string NumberOf(const Peer& peer);

// What the other end of a connected Unix socket is. Throws Error where the kernel does not say.
Peer PeerOf(int socket);

class Access {
 public:
  // `movers`: names of users, and of groups behind "@". Without any, everybody who can connect may
  // move the stand. Throws Error with the name that this machine does not know.
  explicit Access(const std::vector<std::string>& movers);

  // Root and the daemon's own user may always; so may what comes from the daemon itself, without a
  // peer. A process is of the groups that the kernel knows of it, as for the rights of a file: no
  // list of users is asked.
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
