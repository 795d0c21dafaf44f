#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/json_text.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

namespace {

[[noreturn]] void Fail(const fs::path& file, const char* action) {
  throw DataError(fmt::format("{}: {}: {}", file.string(), action, std::strerror(errno)));
}

// An open file that closes itself.
class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags) : file_(file), fd_(open(file.c_str(), flags, 0666)) {
    if (fd_ < 0) Fail(file, "cannot be written");
  }
  ~Descriptor() { close(fd_); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void Write(std::string_view text) {
    while (!text.empty()) {
      const ssize_t written = write(fd_, text.data(), text.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) Fail(file_, "cannot be written");
      text.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  // Some file systems cannot sync a folder: that is no loss of data.
  void Sync() {
    if (fsync(fd_) != 0 && errno != EINVAL) Fail(file_, "cannot be synced");
  }

 private:
  fs::path file_;
  int fd_;
};

void ReplaceFile(const fs::path& temporary, const fs::path& file, std::string_view text) {
  {
    Descriptor out(temporary, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC);
    out.Write(text);
    out.Sync();
  }
  if (rename(temporary.c_str(), file.c_str()) != 0) Fail(file, "cannot be replaced");
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  Descriptor(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC).Sync();
}

}  // namespace

void WriteJsonAtomically(const fs::path& file, const nlohmann::json& value) {
  // Text that is no UTF-8 (a device's name, a script) must not stop the record: it is replaced.
  const std::string text = JsonText(value, 2) + "\n";
  fs::path temporary = file;
  temporary += fmt::format(".{}.part", getpid());
  try {
    ReplaceFile(temporary, file, text);
  } catch (const DataError&) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
}

nlohmann::json ReadJson(const fs::path& file) {
  using Event = nlohmann::json::parse_event_t;
  constexpr int kDeepest = 100;  // what walks over a value calls itself once a level
  std::ifstream in(file, std::ios::binary);
  if (!in) Fail(file, "cannot be opened");
  try {
    return nlohmann::json::parse(in, [&](int depth, Event, nlohmann::json&) {
      if (depth <= kDeepest) return true;
      throw DataError(fmt::format("{}: JSON nested deeper than {}", file.string(), kDeepest));
    });
  } catch (const nlohmann::json::parse_error& error) {
    throw DataError(
        fmt::format("{}: no valid JSON at byte {}: {}", file.string(), error.byte, error.what()));
  } catch (const nlohmann::json::exception& error) {  // a number beyond all doubles
    throw DataError(fmt::format("{}: no usable JSON: {}", file.string(), error.what()));
  }
}

nlohmann::json RunDirectory::ReadRun() const { return ReadJson(RunJson()); }

nlohmann::json RunDirectory::ReadResult() const { return ReadJson(ResultJson()); }

}  // namespace gyrobench::recording
