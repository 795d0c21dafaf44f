#include "recording/run_directory.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "base/error.h"
#include "recording/measurement_files.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxSameName = 99;

std::string SafeName(std::string_view procedure) {
  std::string name;
  for (const char c : procedure) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    name += plain ? c : '_';
  }
  return name.empty() ? "run" : name.substr(0, 40);
}

std::string RunIdFor(std::string_view procedure, Utime start) {
  const auto seconds = static_cast<std::time_t>(start / kMicrosecondsPerSecond);
  return fmt::format("{:%Y%m%d-%H%M%S}-{}", fmt::gmtime(seconds), SafeName(procedure));
}

// When the record was last written to; the folder's own time also changes when a report is added.
fs::file_time_type LastWrite(const fs::path& folder) {
  std::error_code error;
  const auto log_time = fs::last_write_time(folder / kEventLogName, error);
  if (!error) return log_time;
  const auto json_time = fs::last_write_time(folder / kRunJsonName, error);
  return error ? fs::file_time_type::min() : json_time;
}

std::string Names(const std::vector<RunDirectory>& runs) {
  constexpr std::size_t kShown = 8;
  std::string text;
  const std::size_t first = runs.size() > kShown ? runs.size() - kShown : 0;
  for (std::size_t i = first; i < runs.size(); ++i) {
    text += (i > first ? ", " : "") + runs[i].run_id();
  }
  return first > 0 ? "..., " + text : text;
}

std::vector<RunDirectory> WithPrefix(const std::vector<RunDirectory>& runs,
                                     const std::string& name) {
  std::vector<RunDirectory> found;
  for (const RunDirectory& run : runs) {
    if (run.run_id() == name) return {run};
    if (run.run_id().starts_with(name)) found.push_back(run);
  }
  return found;
}

// Shared by who makes a record, since a file system across the network lets nobody lock a folder
// for himself: there, readers find that nobody can tell.
constexpr int kHoldTries = 5;
constexpr std::chrono::milliseconds kHoldPause{2};

class Folder {
 public:
  explicit Folder(const fs::path& path)
      : fd_(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {}
  ~Folder() {
    if (fd_ >= 0) ::close(fd_);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const int& fd() const { return fd_; }

 private:
  const int fd_;
};

// A record that cannot be held is made all the same.
std::shared_ptr<const int> Hold(const fs::path& path) {
  const auto folder = std::make_shared<const Folder>(path);
  if (folder->fd() >= 0) ::flock(folder->fd(), LOCK_SH | LOCK_NB);
  return {folder, &folder->fd()};
}

}  // namespace

void RequireWritable(const fs::path& records) {
  std::error_code error;
  fs::path there = fs::absolute(records, error);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  // What the disk says counts, and not the mode of the folder: a read-only disk, one that is full,
  // a folder that the kernel keeps.
  std::string trial = (there / ".gyrobench-XXXXXX").string();
  if (::mkdtemp(trial.data()) != nullptr) {
    fs::remove(trial, error);
    return;
  }
  throw DataError(fmt::format(
      "{}: no records can be kept there: {} cannot be written to ({}); set `records` in the stand "
      "file to a folder that can",
      records.string(), there.string(), std::strerror(errno)));
}

RunDirectory::RunDirectory(std::string run_id, fs::path folder)
    : run_id_(std::move(run_id)), folder_(std::move(folder)) {}

RunDirectory RunDirectory::Create(const fs::path& records, std::string_view procedure,
                                  Utime start) {
  std::error_code error;
  fs::create_directories(records, error);
  if (!fs::is_directory(records)) {
    throw DataError(fmt::format(
        "{}: the records folder cannot be made: {}; set `records` in the stand file to a folder "
        "that this user may write",
        records.string(), error ? error.message() : "a file of that name is in the way"));
  }
  const std::string base = RunIdFor(procedure, start);
  for (int i = 1; i <= kMaxSameName; ++i) {
    const std::string run_id = i == 1 ? base : fmt::format("{}-{:02}", base, i);
    if (fs::create_directory(records / run_id, error)) {
      RunDirectory made(run_id, records / run_id);
      made.hold_ = Hold(made.folder_);
      return made;
    }
    if (error) {
      throw DataError(fmt::format(
          "{}: a record cannot be made here: {}; give this user the right to write to the folder, "
          "or set `records` in the stand file to another one",
          records.string(), error.message()));
    }
  }
  throw DataError(fmt::format("{}: {} and {} more of that name exist already", records.string(),
                              base, kMaxSameName - 1));
}

bool RunDirectory::IsBeingMade() const {
  const Folder folder(folder_);
  if (folder.fd() < 0) return true;
  for (int tries = 0; tries < kHoldTries; ++tries) {
    if (::flock(folder.fd(), LOCK_EX | LOCK_NB) == 0) return false;  // let go when it is closed
    if (errno != EWOULDBLOCK) return true;
    // Another reader that is asking this very moment, or who makes it.
    std::this_thread::sleep_for(kHoldPause);
  }
  return true;
}

RunDirectory RunDirectory::Open(const fs::path& folder) {
  if (!IsRecordFolder(folder)) {
    throw DataError(fmt::format("{}: no record: expected {} or {} in it", folder.string(),
                                kEventLogName, kRunJsonName));
  }
  const fs::path clean = fs::weakly_canonical(folder);
  return {clean.filename().string(), folder};
}

void RunDirectory::WriteRun(const nlohmann::json& run) const {
  WriteJsonAtomically(RunJson(), run);
}

void RunDirectory::WriteResult(const nlohmann::json& result) const {
  WriteJsonAtomically(ResultJson(), result);
}

std::vector<RunDirectory> ListRuns(const fs::path& records) {
  std::error_code error;
  if (!fs::exists(records, error)) return {};
  fs::directory_iterator entries(records, error);
  if (error)
    throw DataError(fmt::format("{}: cannot be read: {}", records.string(), error.message()));
  std::vector<std::pair<fs::file_time_type, RunDirectory>> found;
  for (const fs::directory_entry& entry : entries) {
    if (IsRecordFolder(entry.path()))
      found.emplace_back(LastWrite(entry), RunDirectory::Open(entry.path()));
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, a.second.run_id()) < std::pair(b.first, b.second.run_id());
  });
  std::vector<RunDirectory> runs;
  runs.reserve(found.size());
  for (auto& [time, run] : found) runs.push_back(std::move(run));
  return runs;
}

RunDirectory FindRun(const fs::path& records, const std::string& name) {
  const std::vector<RunDirectory> runs = ListRuns(records);
  if (name == "latest") {
    if (runs.empty()) throw DataError(fmt::format("{}: holds no records yet", records.string()));
    return runs.back();
  }
  const std::vector<RunDirectory> matches =
      name.empty() ? std::vector<RunDirectory>() : WithPrefix(runs, name);
  if (matches.size() == 1) return matches.front();
  if (matches.size() > 1) {
    throw DataError(
        fmt::format("'{}' is the beginning of {} records in {}: {}; give more of the name", name,
                    matches.size(), records.string(), Names(matches)));
  }
  if (IsRecordFolder(name)) return RunDirectory::Open(name);
  if (fs::is_regular_file(name) && IsRecordFolder(fs::path(name).parent_path())) {
    return RunDirectory::Open(fs::path(name).parent_path());
  }
  if (fs::is_regular_file(name)) {
    throw DataError(
        fmt::format("{}: expected a run, the folder of its record or a file within one; found a "
                    "file of its own",
                    name));
  }
  if (records.empty()) {
    throw DataError(
        fmt::format("no record '{}': no folder of records is known; give --records, --config or "
                    "GYROBENCH_CONFIG",
                    name));
  }
  throw DataError(fmt::format("no record '{}' in {}: {}", name, records.string(),
                              runs.empty() ? "it holds none" : "there are " + Names(runs)));
}

}  // namespace gyrobench::recording
