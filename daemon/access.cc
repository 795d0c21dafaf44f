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

// Null where there is none.
const passwd* UserEntry(uid_t user_id, passwd* entry, EntryText* text) {
  passwd* found = nullptr;
  ::getpwuid_r(user_id, entry, text->data(), text->size(), &found);
  return found;
}

std::vector<gid_t> GroupsOf(const Peer& peer) {
  std::vector<gid_t> groups = {peer.group_id};
  passwd entry{};
  EntryText text;
  const passwd* user = UserEntry(peer.user_id, &entry, &text);
  if (user == nullptr) return groups;
  int count = 64;
  groups.resize(static_cast<std::size_t>(count));
  // It says how many there are where they are more.
  if (::getgrouplist(user->pw_name, peer.group_id, groups.data(), &count) < 0) {
    groups.resize(static_cast<std::size_t>(count));
    ::getgrouplist(user->pw_name, peer.group_id, groups.data(), &count);
  }
  groups.resize(static_cast<std::size_t>(count));
  return groups;
}

}  // namespace

std::string NameOf(const Peer& peer) {
  passwd entry{};
  EntryText text;
  const passwd* user = UserEntry(peer.user_id, &entry, &text);
  return fmt::format("{} (process {})",
                     user != nullptr ? user->pw_name : fmt::format("user {}", peer.user_id),
                     peer.process);
}

Peer PeerOf(int socket) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) {
    throw Error(fmt::format("the kernel does not say who connected: {}",
                            std::generic_category().message(errno)));
  }
  return {credentials.pid, credentials.uid, credentials.gid};
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
  if (users_.contains(peer->user_id)) return true;
  return !groups_.empty() && std::ranges::any_of(GroupsOf(*peer), [this](gid_t group_id) {
    return groups_.contains(group_id);
  });
}

}  // namespace gyrobench::daemon
