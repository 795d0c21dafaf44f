#include "daemon/disk_room.h"

#include <fmt/format.h>

#include <system_error>

namespace gyrobench::daemon {

namespace fs = std::filesystem;

std::string TooLittleRoom(const fs::path& folder, double min_free_mib) {
  std::error_code error;
  fs::path there = fs::absolute(folder, error);
  while (!fs::exists(there, error) && there.has_relative_path()) there = there.parent_path();
  const fs::space_info room = fs::space(there, error);
  if (error) return {};
  const double free_mib = static_cast<double>(room.available) / (1024.0 * 1024.0);
  if (free_mib >= min_free_mib) return {};
  return fmt::format(
      "{}: {:.1f} MiB are free on the disk of the records, expected at least {:g} MiB "
      "(safety.min_free_mib). Move records away or give them another disk",
      folder.string(), free_mib, min_free_mib);
}

}  // namespace gyrobench::daemon
