#include "recording/measurement_files.h"

#include <fmt/format.h>
#include <glib.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

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

std::string Sha256OfFile(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw DataError(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
  }
  const std::unique_ptr<GChecksum, decltype(&g_checksum_free)> sum(
      g_checksum_new(G_CHECKSUM_SHA256), g_checksum_free);
  std::vector<char> block(std::size_t{1} << 16);
  std::vector<guchar> bytes(block.size());
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    const auto count = static_cast<std::size_t>(in.gcount());
    std::memcpy(bytes.data(), block.data(), count);
    g_checksum_update(sum.get(), bytes.data(), static_cast<gssize>(count));
  }
  if (in.bad()) throw DataError(fmt::format("{}: cannot be read to its end", file.string()));
  return g_checksum_get_string(sum.get());
}

}  // namespace gyrobench::recording
