// Room on the disk of the records.
#pragma once

#include <filesystem>
#include <string>

namespace gyrobench::daemon {

// What is wrong where less than `min_free_mib` is free for this user on the disk of `folder` (or of
// its nearest parent that is there), or where the disk fails to say so, three times on end; empty
// where there is enough.
std::string WhyNoRoom(const std::filesystem::path& folder, double min_free_mib);

}  // namespace gyrobench::daemon
