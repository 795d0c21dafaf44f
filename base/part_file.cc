#include "base/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.h"

namespace gyrobench {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void FailOn(const fs::path& file, const char* action) {
  throw DataError(fmt::format("{}: {}: {}", file.string(), action, std::strerror(errno)));
}

// Some file systems cannot sync a folder: that is no loss of data.
void SyncDescriptor(int fd, const fs::path& file) {
  if (fsync(fd) != 0 && errno != EINVAL) FailOn(file, "cannot be synced");
}

}  // namespace

PartFile::PartFile(const fs::path& file) : file_(file) {
  static std::atomic<unsigned> count = 0;
  constexpr int kMostTries = 1000;
  for (int tries = 0; fd_ < 0; ++tries) {
    part_ = file_;
    part_ += fmt::format(".{}-{}.part", getpid(), count++);
    fd_ = open(part_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    // One of a process that was killed and had our number.
    if (fd_ < 0 && (errno != EEXIST || tries == kMostTries)) FailOn(file_, "cannot be written");
  }
}

PartFile::~PartFile() {
  Close();
  if (!replaced_) unlink(part_.c_str());
}

void PartFile::Close() {
  if (fd_ >= 0) close(std::exchange(fd_, -1));
}

int PartFile::TakeDescriptor() { return std::exchange(fd_, -1); }

void PartFile::Write(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(fd_, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) FailOn(file_, "cannot be written");
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void PartFile::Replace(Safety safety) {
  if (safety == Safety::kOnDisk) SyncDescriptor(fd_, file_);
  Close();
  if (rename(part_.c_str(), file_.c_str()) != 0) FailOn(file_, "cannot be replaced");
  replaced_ = true;
  if (safety == Safety::kNone) return;
  const fs::path folder = file_.has_parent_path() ? file_.parent_path() : fs::path(".");
  const int fd = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) FailOn(folder, "cannot be synced");
  const bool synced = fsync(fd) == 0 || errno == EINVAL;
  const int error = errno;
  close(fd);
  errno = error;
  if (!synced) FailOn(folder, "cannot be synced");
}

}  // namespace gyrobench
