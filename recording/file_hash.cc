#include "recording/file_hash.h"

#include <fmt/format.h>
#include <glib.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <vector>

#include "base/error.h"

namespace gyrobench::recording {

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
