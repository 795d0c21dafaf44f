#include "daemon/disk_room.h"

#include <fmt/format.h>

#include <system_error>

namespace gyrobench::daemon {
namespace {

namespace fs = std::filesystem;

// A signal or a moment's trouble of the disk is no reason to end a run.
constexpr int kTries = 3;

fs::space_info RoomAt(const fs::path& folder, std::error_code& error) {
  fs::path there = fs::absolute(folder, error);
  for (; !error; there = there.parent_path()) {
    const fs::file_type found = fs::status(there, error).type();
    // Only what is not there yet is looked for further up: what cannot be looked at is on that disk.
    if (found != fs::file_type::not_found) break;
    error.clear();
    if (!there.has_relative_path()) break;
  }
  return error ? fs::space_info{} : fs::space(there, error);
}

}  // namespace

std::string WhyNoRoom(const fs::path& folder, double min_free_mib) {
  std::error_code error;
  fs::space_info room = RoomAt(folder, error);
  for (int tries = 1; error && tries < kTries; ++tries) room = RoomAt(folder, error);
  if (error) {
    return fmt::format(
        "{}: the disk of the records cannot be asked how much room it has: {} ({} tries); expected "
        "at least {:g} MiB free (safety.min_free_mib). See to the disk and how it is mounted, or "
        "give the records another one",
        folder.string(), error.message(), kTries, min_free_mib);
  }
  const double free_mib = static_cast<double>(room.available) / (1024.0 * 1024.0);
  if (free_mib >= min_free_mib) return {};
  return fmt::format(
      "{}: {:.1f} MiB are free on the disk of the records, expected at least {:g} MiB "
      "(safety.min_free_mib). Move records away or give them another disk",
      folder.string(), free_mib, min_free_mib);
}

}  // namespace gyrobench::daemon
