// The bytes of a text file, plain or gzip, as a stream.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>

#include "base/measurement.h"

namespace gyrobench::recording {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  // Up to `capacity` bytes into `out`; 0 at the end. Throws DataError when the disk cannot be read.
  virtual std::size_t Read(char* out, std::size_t capacity) = 0;
  // Of the file on disk, 0..1.
  virtual double fraction() const = 0;
  // Why the stream ended before its end, with the byte of the file on disk: `truncated_gzip`,
  // `damaged_gzip`.
  virtual const std::optional<Defect>& damage() const = 0;
};

// Opens a file; gzip is told by its first bytes, not by the name. Throws DataError when it cannot
// be opened.
std::unique_ptr<ByteSource> OpenByteSource(const std::filesystem::path& file);

}  // namespace gyrobench::recording
