#include "recording/replay.h"

#include <fmt/format.h>

#include <array>
#include <fstream>

#include "base/error.h"
#include "recording/run_directory.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

namespace {

bool BeginsWithSyncWord(const fs::path& file) {
  std::array<char, 4> begin = {};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  return begin == std::array<char, 4>{'\xED', '\xA1', '\xDA', '\x01'};
}

}  // namespace

void Replay(const fs::path& path, MeasurementSink& sink, const ReplayProgress& progress) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw DataError(
        fmt::format("{}: no such file or folder; expected a record, a measurement table "
                    "(.csv, .csv.gz) or an event log",
                    path.string()));
  }
  const std::string name = path.filename().string();
  if (fs::is_directory(status) || name == kRunJsonName || name == kResultJsonName) {
    return ReplayRun(fs::is_directory(status) ? path : path.parent_path(), sink, progress);
  }
  const bool named_table = name.ends_with(".csv") || name.ends_with(".csv.gz");
  if (name == kEventLogName || (!named_table && BeginsWithSyncWord(path))) {
    return ReplayRun(path, sink, progress);
  }
  ReplayTable(path, sink, progress);
}

}  // namespace gyrobench::recording
