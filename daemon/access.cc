#include "daemon/access.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <grp.h>
#include <pwd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>

#include "base/error.h"

namespace gyrobench::daemon {
namespace {

// What getpwnam_r and the like need for the texts of one entry.
using EntryText = std::array<char, 16384>;

// Without any where the kernel is older than the question (before 4.13).
std::vector<gid_t> GroupsAt(int socket) {
  std::vector<gid_t> groups(64);
  for (;;) {
    socklen_t bytes = static_cast<socklen_t>(groups.size() * sizeof(gid_t));
    const bool told = ::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &bytes) == 0;
    const bool more = !told && errno == ERANGE && bytes > groups.size() * sizeof(gid_t);
    groups.resize(told || more ? bytes / sizeof(gid_t) : 0);
    if (!more) return groups;
  }
}

}  // namespace

std::string NumberOf(const Peer& peer) {
  return fmt::format("user {} (process {})", peer.user_id, peer.process);
}

std::string NameOf(const Peer& peer) {
  passwd entry{};
  EntryText text;
  passwd* found = nullptr;
  ::getpwuid_r(peer.user_id, &entry, text.data(), text.size(), &found);
  if (found == nullptr) return NumberOf(peer);
  return fmt::format("{} (process {})", found->pw_name, peer.process);
}

Peer PeerOf(int socket) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) {
    throw Error(fmt::format("the kernel does not say who connected: {}",
                            std::generic_category().message(errno)));
  }
  return {credentials.pid, credentials.uid, credentials.gid, GroupsAt(socket)};
}

uid_t UserByName(const std::string& name) {
  passwd entry{};
  EntryText text;
  passwd* found = nullptr;
  ::getpwnam_r(name.c_str(), &entry, text.data(), text.size(), &found);
  if (found == nullptr) throw Error(fmt::format("this machine has no user \"{}\"", name));
  return found->pw_uid;
}

gid_t GroupByName(const std::string& name) {
  group entry{};
  EntryText text;
  group* found = nullptr;
  ::getgrnam_r(name.c_str(), &entry, text.data(), text.size(), &found);
  if (found == nullptr) throw Error(fmt::format("this machine has no group \"{}\"", name));
  return found->gr_gid;
}

Access::Access(const std::vector<std::string>& movers)
    : everybody_(movers.empty()), text_(fmt::format("{}", fmt::join(movers, ", "))) {
  for (const std::string& name : movers) {
    if (name.starts_with('@')) {
      groups_.insert(GroupByName(name.substr(1)));
    } else {
      users_.insert(UserByName(name));
    }
  }
}

bool Access::MayMove(const std::optional<Peer>& peer) const {
  if (everybody_ || !peer || peer->user_id == 0 || peer->user_id == ::geteuid()) return true;
  if (users_.contains(peer->user_id) || groups_.contains(peer->group_id)) return true;
  return std::ranges::any_of(peer->groups, [this](gid_t group) { return groups_.contains(group); });
}

}  // namespace gyrobench::daemon
