#include "recording/measurement_files.h"

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

bool IsEventLog(const fs::path& file) {
  const std::string name = file.filename().string();
  const bool named_table = name.ends_with(".csv") || name.ends_with(".csv.gz");
  return name == kEventLogName || (!named_table && BeginsWithSyncWord(file));
}

fs::path FolderOf(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

MeasurementFiles Record(const fs::path& folder, const fs::path& log) {
  MeasurementFiles found{true, folder, {}};
  std::error_code none;
  for (const fs::path& file : {log, folder / kRunJsonName}) {
    if (fs::is_regular_file(file, none)) found.files.push_back(file);
  }
  return found;
}

}  // namespace

MeasurementFiles FilesOfMeasurement(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) {
    throw DataError(
        fmt::format("{}: no such file or folder; expected a record, a measurement table "
                    "(.csv, .csv.gz) or an event log",
                    path.string()));
  }
  if (fs::is_directory(status)) return Record(path, path / kEventLogName);
  const std::string name = path.filename().string();
  const fs::path folder = FolderOf(path);
  if (name == kRunJsonName || name == kResultJsonName)
    return Record(folder, folder / kEventLogName);
  if (IsEventLog(path)) return Record(folder, path);
  return {false, folder, {path}};
}

bool IsRecordFolder(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / kEventLogName, error) || fs::exists(folder / kRunJsonName, error);
}

}  // namespace gyrobench::recording
