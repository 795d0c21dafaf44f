#include "drivers/stand_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <set>
#include <system_error>

#include "base/error.h"

namespace gyrobench::drivers {
namespace {

namespace fs = std::filesystem;

// The same for every user of the machine: one that all may write to.
fs::path LockFolder() {
  for (const char* folder : {"/run/lock", "/tmp"}) {
    struct stat status {};
    if (::stat(folder, &status) == 0 && (status.st_mode & S_IWOTH) != 0) return folder;
  }
  throw Error("neither /run/lock nor /tmp can be written by all: the stand cannot be locked");
}

// FNV-1a: the same in every build.
std::string HashOf(const std::string& text) {
  std::uint64_t hash = 14695981039346656037U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211U;
  return fmt::format("{:016x}", hash);
}

// Where it is, whatever links lead there; a part that is not there yet stays as it is written.
std::string PlaceOf(const fs::path& path) {
  std::error_code error;
  const fs::path found = fs::weakly_canonical(fs::absolute(path), error);
  return (error ? path : found).string();
}

// All numeric addresses that the name has, or itself where it has none now.
std::set<std::string> AddressesOf(const config::BusConfig& bus) {
  std::set<std::string> keys;
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(bus.host.c_str(), nullptr, &wanted, &found) == 0) {
    for (const addrinfo* one = found; one != nullptr; one = one->ai_next) {
      std::array<char, NI_MAXHOST> host = {};
      if (::getnameinfo(one->ai_addr, one->ai_addrlen, host.data(), host.size(), nullptr, 0,
                        NI_NUMERICHOST) == 0) {
        keys.insert(fmt::format("tcp {} {}", host.data(), bus.port));
      }
    }
    ::freeaddrinfo(found);
  }
  if (keys.empty()) keys.insert(fmt::format("tcp {} {}", bus.host, bus.port));
  return keys;
}

// Opens or makes it; a link, or what is no file, is somebody's trap and not a lock.
int OpenLock(const fs::path& file) {
  constexpr int kFlags = O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  int fd = ::open(file.c_str(), kFlags);
  if (fd < 0 && errno == ENOENT) {
    fd = ::open(file.c_str(), kFlags | O_CREAT | O_EXCL, 0666);
    // Another user's daemon is to find out as well.
    if (fd >= 0) ::fchmod(fd, 0666);
    if (fd < 0 && errno == EEXIST) fd = ::open(file.c_str(), kFlags);
  }
  struct stat status {};
  if (fd >= 0 && (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode))) {
    ::close(fd);
    fd = -1;
    errno = EINVAL;
  }
  if (fd >= 0) return fd;
  throw Error(fmt::format("{}: the lock cannot be opened: {}. Remove what is in its place",
                          file.string(), std::strerror(errno)));
}

bool IsStillThere(int fd, const fs::path& file) {
  struct stat opened {
  }, named{};
  return ::fstat(fd, &opened) == 0 && ::lstat(file.c_str(), &named) == 0 &&
         opened.st_ino == named.st_ino && opened.st_dev == named.st_dev;
}

std::string HolderOf(int fd) {
  std::array<char, 512> text = {};
  const ssize_t size = ::pread(fd, text.data(), text.size(), 0);
  const std::string holder(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  return holder.empty() ? "a process that did not say who it is" : holder;
}

}  // namespace

StandLock::StandLock(const config::StandConfig& stand, const std::string& program) {
  const std::string holder = fmt::format("{}, process {}, control socket {}", program, ::getpid(),
                                         PlaceOf(stand.control_socket));
  try {
    if (!stand.virtual_stand) {
      for (const config::BusConfig& bus : stand.buses) {
        if (bus.transport == config::BusConfig::Transport::kTcp) {
          for (const std::string& key : AddressesOf(bus)) {
            Take(fmt::format("bus {} ({}:{})", bus.name, bus.host, bus.port), key, holder);
          }
          continue;
        }
        const std::string place = PlaceOf(bus.device);
        Take(fmt::format("bus {} ({})", bus.name, place), "line " + place, holder);
      }
    }
    const std::string socket = PlaceOf(stand.control_socket);
    Take("control socket " + socket, "socket " + socket, holder);
    const std::string records = PlaceOf(stand.records);
    Take("folder of records " + records, "records " + records, holder);
  } catch (...) {
    Release();
    throw;
  }
}

StandLock::~StandLock() { Release(); }

void StandLock::Release() {
  // Removed while it is held, so that nobody else's is.
  for (const Held& held : held_) {
    ::unlink(held.file.c_str());
    ::close(held.fd);
  }
  held_.clear();
}

void StandLock::Take(const std::string& what, const std::string& key, const std::string& holder) {
  const bool mine =
      std::any_of(held_.begin(), held_.end(), [&](const Held& held) { return held.key == key; });
  if (mine) return;  // two buses on one gateway, say
  const fs::path file = LockFolder() / ("gyrobench-" + HashOf(key) + ".lock");
  for (;;) {
    const int fd = OpenLock(file);
    if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
      const std::string message = fmt::format(
          "{} is in use by {}. End that one first, or give this "
          "stand file lines, a control socket and records of its own",
          what, HolderOf(fd));
      ::close(fd);
      throw Error(message);
    }
    if (!IsStillThere(fd, file)) {  // its holder has just removed it
      ::close(fd);
      continue;
    }
    held_.push_back({key, file, fd});
    // Who it is helps a person and is no part of the lock.
    if (::ftruncate(fd, 0) == 0) {
      [[maybe_unused]] const ssize_t written = ::pwrite(fd, holder.data(), holder.size(), 0);
    }
    return;
  }
}

}  // namespace gyrobench::drivers
