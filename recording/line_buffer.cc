#include "recording/line_buffer.h"

#include <cstring>
#include <utility>

namespace gyrobench::recording {

LineBuffer::LineBuffer(std::unique_ptr<ByteSource> source)
    : source_(std::move(source)), buffer_(kMaxLine) {}

// Reads once. At the end of the stream closes the last line.
bool LineBuffer::Fill() {
  if (ended_) return false;
  const std::size_t got = source_->Read(buffer_.data() + tail_, buffer_.size() - tail_ - 1);
  tail_ += got;
  if (got > 0) return true;
  ended_ = true;
  if (tail_ == 0 || source_->damage()) return false;
  buffer_[tail_++] = '\n';
  return true;
}

// The buffer holds the beginning of a line that does not fit: drops all of it. False when the file
// ends in it.
bool LineBuffer::SkipLongLine() {
  while (true) {
    tail_ = 0;
    if (!Fill()) return false;
    const void* feed = std::memchr(buffer_.data(), '\n', tail_);
    if (feed == nullptr) continue;
    const auto rest = static_cast<std::size_t>(static_cast<const char*>(feed) - buffer_.data()) + 1;
    std::memmove(buffer_.data(), buffer_.data() + rest, tail_ - rest);
    tail_ -= rest;
    return true;
  }
}

bool LineBuffer::Next(LineBlock& block) {
  block = {};
  std::memmove(buffer_.data(), buffer_.data() + given_, tail_ - given_);
  tail_ -= given_;
  given_ = 0;
  while (true) {
    const void* feed = tail_ > 0 ? memrchr(buffer_.data(), '\n', tail_) : nullptr;
    if (feed != nullptr) {
      block.begin = buffer_.data();
      block.end = static_cast<const char*>(feed) + 1;
      given_ = static_cast<std::size_t>(block.end - block.begin);
      return true;
    }
    if (tail_ + 1 >= buffer_.size()) {
      block.after_long_line = true;
      if (!SkipLongLine()) {
        tail_ = 0;
        return true;
      }
    } else if (!Fill()) {
      tail_ = 0;
      return block.after_long_line;
    }
  }
}

}  // namespace gyrobench::recording
