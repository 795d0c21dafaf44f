#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "base/error.h"
#include "recording/event_checksum.h"
#include "recording/event_log.h"

namespace gyrobench::recording {

namespace {

constexpr std::array<std::uint8_t, 4> kSync = {0xED, 0xA1, 0xDA, 0x01};
constexpr std::size_t kHeaderSize = 28;
constexpr std::size_t kReadSize = std::size_t{256} * 1024;
constexpr std::size_t kMaxDamageEntries = 100;

std::uint64_t BigEndian(const std::uint8_t* bytes, int count) {
  std::uint64_t value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[i];
  return value;
}

}  // namespace

struct EventLogReader::Header {
  std::uint32_t checksum = 0;  // 0 where it has none
  std::int64_t number = 0;
  Utime utime = 0;
  std::size_t channel_size = 0;
  std::size_t data_size = 0;
  std::size_t event_size() const { return kHeaderSize + channel_size + data_size; }
};

EventLogReader::EventLogReader(const std::filesystem::path& file)
    : file_(file), descriptor_(open(file.c_str(), O_RDONLY | O_CLOEXEC)), buffer_(2 * kReadSize) {
  struct stat status = {};
  if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
    throw DataError(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
  }
  file_size_ = status.st_size;
}

EventLogReader::~EventLogReader() {
  if (descriptor_ >= 0) close(descriptor_);
}

double EventLogReader::fraction() const {
  if (file_size_ <= 0) return 1.0;
  return std::min(1.0, static_cast<double>(head_byte_) / static_cast<double>(file_size_));
}

// Makes `bytes` bytes available from head_ on. False when the file ends before.
bool EventLogReader::Ensure(std::size_t bytes) {
  if (available() >= bytes) return true;
  if (head_ + bytes > buffer_.size()) {
    std::memmove(buffer_.data(), buffer_.data() + head_, available());
    tail_ -= head_;
    head_ = 0;
    if (bytes > buffer_.size()) buffer_.resize(bytes + kReadSize);
  }
  while (available() < bytes) {
    const ssize_t got = read(descriptor_, buffer_.data() + tail_, buffer_.size() - tail_);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      throw DataError(fmt::format("{}: cannot be read at byte {}: {}", file_.string(),
                                  head_byte_ + static_cast<std::int64_t>(available()),
                                  std::strerror(errno)));
    }
    if (got == 0) return false;
    tail_ += static_cast<std::size_t>(got);
  }
  return true;
}

// The header `offset` bytes after head_, if its sync word, number, lengths and channel name are
// sound. No more is looked at than is in memory.
std::optional<EventLogReader::Header> EventLogReader::HeaderAt(std::size_t offset) const {
  if (available() < offset + kHeaderSize) return std::nullopt;
  const std::uint8_t* bytes = buffer_.data() + head_ + offset;
  if (!std::equal(kSync.begin(), kSync.end(), bytes)) return std::nullopt;
  Header header;
  header.checksum = static_cast<std::uint32_t>(BigEndian(bytes + kEventNumberAt, 4));
  header.number = static_cast<std::int64_t>(BigEndian(bytes + kEventNumberAt + 4, 4));
  header.utime = static_cast<Utime>(BigEndian(bytes + 12, 8));
  header.channel_size = BigEndian(bytes + 20, 4);
  header.data_size = BigEndian(bytes + 24, 4);
  if (header.channel_size < 1 || header.channel_size > kMaxChannelLength ||
      header.data_size > kMaxEventData) {
    return std::nullopt;
  }
  const std::size_t seen = std::min(header.channel_size, available() - offset - kHeaderSize);
  const std::uint8_t* name = bytes + kHeaderSize;
  const bool printable =
      std::all_of(name, name + seen, [](std::uint8_t c) { return c >= ' ' && c < 127; });
  return printable ? std::optional(header) : std::nullopt;
}

// Offset from head_ of the first sound header that begins in [from, to).
std::optional<std::size_t> EventLogReader::NextHeader(std::size_t from, std::size_t to) const {
  const std::uint8_t* base = buffer_.data() + head_;
  const std::size_t end = std::min(to, available());
  while (from + kSync.size() <= end) {
    const void* found = memmem(base + from, end - from, kSync.data(), kSync.size());
    if (found == nullptr) return std::nullopt;
    from = static_cast<std::size_t>(static_cast<const std::uint8_t*>(found) - base);
    if (HeaderAt(from)) return from;
    from += 1;
  }
  return std::nullopt;
}

// Whether the event at head_ may be believed: it is all there, and its checksum is right. In a log
// with checksums, an event without one is none: a page that was never written is zero.
bool EventLogReader::IsWhole(const Header& header) {
  const std::size_t size = header.event_size();
  Ensure(size + kSync.size());
  if (available() < size) return false;
  if (header.checksum == 0) return !has_checksums_ && IsFollowed(size);
  if (EventChecksum(buffer_.data() + head_, size) != header.checksum) return false;
  has_checksums_ = true;
  return true;
}

// Whether another event or the end follows the one at head_. Where something else follows, either
// this event's length is damaged (a header lies within what it claims) or the damage comes after
// it.
bool EventLogReader::IsFollowed(std::size_t size) const {
  const std::size_t after = std::min(kSync.size(), available() - size);
  const std::uint8_t* next = buffer_.data() + head_ + size;
  if (std::equal(next, next + after, kSync.begin())) return true;
  return !NextHeader(kSync.size(), size);
}

// Whether what is left is the beginning of an event that the file's end cut.
bool EventLogReader::EndsTruncated(const std::optional<Header>& header) {
  if (Ensure(header ? header->event_size() : kHeaderSize)) return false;
  if (!header) {
    const std::size_t seen = std::min(kSync.size(), available());
    return std::equal(kSync.begin(), kSync.begin() + static_cast<std::ptrdiff_t>(seen),
                      buffer_.data() + head_);
  }
  return !NextHeader(kSync.size(), available());
}

// Moves head_ forward to the next sound header, or to the end.
void EventLogReader::SkipDamage() {
  if (!damage_begin_) damage_begin_ = head_byte_;
  std::size_t from = 1;
  while (true) {
    const bool more = Ensure(kReadSize);
    const std::optional<std::size_t> found = NextHeader(from, available());
    // A header that the buffer cuts is looked at again with what follows it.
    const std::size_t keep = more ? std::min(available() - 1, kHeaderSize + kMaxChannelLength) : 0;
    const std::size_t skip = found ? *found : available() - keep;
    head_ += skip;
    head_byte_ += static_cast<std::int64_t>(skip);
    if (found || !more) return;
    from = 0;
  }
}

void EventLogReader::Report(std::string kind, std::int64_t count, std::string where) {
  if (damage_.size() < kMaxDamageEntries) {
    damage_.push_back({{std::move(kind), count, kMissing, std::move(where)}, last_utime_});
    return;
  }
  LogDamage& last = damage_.back();
  last.kind = "further_damage";
  last.count += count;
}

void EventLogReader::CloseDamage(std::int64_t end_byte, std::int64_t events_lost) {
  if (!damage_begin_) return;
  Report("damaged_log", std::max<std::int64_t>(1, events_lost),
         fmt::format("byte {}, {} bytes", *damage_begin_, end_byte - *damage_begin_));
  damage_begin_.reset();
}

void EventLogReader::CheckNumber(const Header& header) {
  const std::int64_t lost = next_number_ ? header.number - *next_number_ : 0;
  if (damage_begin_) {
    CloseDamage(head_byte_, lost);
  } else if (lost > 0) {
    Report("missing_events", lost, fmt::format("before byte {}", head_byte_));
  }
  next_number_ = header.number + 1;
}

bool EventLogReader::Next(LogEvent& event) {
  head_ += consumed_;
  head_byte_ += static_cast<std::int64_t>(consumed_);
  consumed_ = 0;
  while (Ensure(1)) {
    Ensure(kHeaderSize + kMaxChannelLength);
    const std::optional<Header> header = HeaderAt(0);
    if (header && IsWhole(*header)) {
      CheckNumber(*header);
      const std::uint8_t* bytes = buffer_.data() + head_ + kHeaderSize;
      last_utime_ = header->utime;
      event.utime = header->utime;
      event.number = header->number;
      event.byte = head_byte_;
      event.channel = {reinterpret_cast<const char*>(bytes), header->channel_size};
      event.data = {bytes + header->channel_size, header->data_size};
      consumed_ = header->event_size();
      return true;
    }
    if (EndsTruncated(header)) {
      CloseDamage(head_byte_, 0);
      Report("truncated_log", 1,
             fmt::format("byte {}, the last {} bytes", head_byte_, available()));
      head_byte_ += static_cast<std::int64_t>(available());
      head_ = tail_;
      return false;
    }
    SkipDamage();
  }
  CloseDamage(head_byte_, 0);
  return false;
}

}  // namespace gyrobench::recording
