// What a result was made from, to the bit.
#pragma once

#include <filesystem>
#include <string>

namespace gyrobench::recording {

// SHA-256 of a file's bytes, 64 hexadecimal digits, read as a stream. Throws DataError.
std::string Sha256OfFile(const std::filesystem::path& file);

}  // namespace gyrobench::recording
