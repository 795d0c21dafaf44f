// The bytes of a text file, plain or gzip, as a stream, and whole lines out of it, many at a time,
// in memory that does not grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

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

// One stretch of whole lines; *(end - 1) is a line feed.
struct LineBlock {
  const char* begin = nullptr;
  const char* end = nullptr;
  bool after_long_line = false;  // one line longer than kMaxLine was skipped before `begin`
};

class LineBuffer {
 public:
  static constexpr std::size_t kMaxLine = std::size_t{256} * 1024;

  explicit LineBuffer(std::unique_ptr<ByteSource> source);
  // The next lines; false at the end. The block holds until the next call. A last line without a
  // line feed gets one, unless the stream broke off in it: then it is left out.
  bool Next(LineBlock& block);
  const ByteSource& source() const { return *source_; }

 private:
  bool Fill();
  bool SkipLongLine();

  std::unique_ptr<ByteSource> source_;
  std::vector<char> buffer_;
  std::size_t given_ = 0;  // end of the lines handed out
  std::size_t tail_ = 0;   // end of the bytes read
  bool ended_ = false;
};

}  // namespace gyrobench::recording
