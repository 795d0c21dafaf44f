#include "recording/line_buffer.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "base/error.h"

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

namespace {

// The file as it lies on the disk.
class PlainSource final : public ByteSource {
 public:
  explicit PlainSource(const std::filesystem::path& file)
      : file_(file), descriptor_(open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    struct stat status = {};
    if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
      throw DataError(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
    }
    size_ = status.st_size;
    posix_fadvise(descriptor_, 0, 0, POSIX_FADV_SEQUENTIAL);
  }
  ~PlainSource() override {
    if (descriptor_ >= 0) close(descriptor_);
  }
  PlainSource(const PlainSource&) = delete;
  PlainSource& operator=(const PlainSource&) = delete;

  std::size_t Read(char* out, std::size_t capacity) override {
    while (true) {
      const ssize_t got = read(descriptor_, out, capacity);
      if (got >= 0) {
        position_ += got;
        return static_cast<std::size_t>(got);
      }
      if (errno == EINTR) continue;
      throw DataError(fmt::format("{}: cannot be read at byte {}: {}", file_.string(), position_,
                                  std::strerror(errno)));
    }
  }
  double fraction() const override {
    return size_ > 0 ? std::min(1.0, static_cast<double>(position_) / static_cast<double>(size_))
                     : 1.0;
  }
  const std::optional<Defect>& damage() const override { return damage_; }

  std::int64_t position() const { return position_; }
  bool BeginsWithGzipMagic() const {
    unsigned char magic[2] = {};
    return pread(descriptor_, magic, 2, 0) == 2 && magic[0] == 0x1f && magic[1] == 0x8b;
  }

 private:
  std::filesystem::path file_;
  int descriptor_;
  std::int64_t size_ = 0;
  std::int64_t position_ = 0;
  std::optional<Defect> damage_;
};

// Inflates one or more gzip members.
class GzipSource final : public ByteSource {
 public:
  explicit GzipSource(std::unique_ptr<PlainSource> file)
      : file_(std::move(file)), input_(kInputSize) {
    constexpr int kGzipOnly = 16 + MAX_WBITS;
    if (inflateInit2(&stream_, kGzipOnly) != Z_OK) throw DataError("zlib cannot be started");
  }
  ~GzipSource() override { inflateEnd(&stream_); }
  GzipSource(const GzipSource&) = delete;
  GzipSource& operator=(const GzipSource&) = delete;

  std::size_t Read(char* out, std::size_t capacity) override {
    stream_.next_out = reinterpret_cast<Bytef*>(out);
    stream_.avail_out = static_cast<uInt>(std::min<std::size_t>(capacity, kMaxOutput));
    const uInt wanted = stream_.avail_out;
    while (!ended_ && stream_.avail_out == wanted) Step();
    return wanted - stream_.avail_out;
  }
  double fraction() const override { return file_->fraction(); }
  const std::optional<Defect>& damage() const override { return damage_; }

 private:
  static constexpr std::size_t kInputSize = std::size_t{64} * 1024;
  static constexpr std::size_t kMaxOutput = 1u << 30;

  void End(const char* kind, const std::string& why) {
    ended_ = true;
    const std::int64_t byte = file_->position() - static_cast<std::int64_t>(stream_.avail_in);
    damage_ = Defect{kind, 1, kMissing, fmt::format("byte {}: {}", byte, why)};
  }
  bool Refill() {
    if (stream_.avail_in > 0) return true;
    stream_.next_in = input_.data();
    stream_.avail_in =
        static_cast<uInt>(file_->Read(reinterpret_cast<char*>(input_.data()), input_.size()));
    return stream_.avail_in > 0;
  }
  // After a member's end: the next member, padding with zeros, or the end.
  void BeginMember() {
    while (Refill() && *stream_.next_in == 0) {
      ++stream_.next_in;
      --stream_.avail_in;
    }
    between_members_ = false;
    ended_ = stream_.avail_in == 0;
    if (!ended_) inflateReset(&stream_);
  }
  void Step() {
    if (between_members_) return BeginMember();
    if (!Refill()) return End("truncated_gzip", "the compressed data end too soon");
    const int result = inflate(&stream_, Z_NO_FLUSH);
    if (result == Z_STREAM_END) {
      between_members_ = true;
    } else if (result != Z_OK && result != Z_BUF_ERROR) {
      End("damaged_gzip", stream_.msg != nullptr ? stream_.msg : "no valid compressed data");
    }
  }

  std::unique_ptr<PlainSource> file_;
  std::vector<Bytef> input_;
  z_stream stream_ = {};
  bool between_members_ = false;
  bool ended_ = false;
  std::optional<Defect> damage_;
};

}  // namespace

std::unique_ptr<ByteSource> OpenByteSource(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) {
    throw DataError(fmt::format("{}: is a folder, expected a file", file.string()));
  }
  auto plain = std::make_unique<PlainSource>(file);
  if (!plain->BeginsWithGzipMagic()) return plain;
  return std::make_unique<GzipSource>(std::move(plain));
}

}  // namespace gyrobench::recording
