// Whole lines out of a stream of bytes, many at a time, in memory that does not grow.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "recording/byte_source.h"

namespace gyrobench::recording {

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
