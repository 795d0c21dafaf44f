// The event log of a record, in the format of LCM: its own tools (lcm-logplayer) read what is
// written here, and logs of lcm-logger can be read here.
//
// An event: sync word 0xEDA1DA01, checksum (4 bytes), event number (4), time stamp (8, microseconds
// since the epoch), length of the channel's name (4), length of the data (4), name, data. All
// big-endian. To LCM, checksum and number are one number of 8 bytes (event_checksum.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.h"
#include "base/measurement.h"

namespace gyrobench::recording {

inline constexpr std::size_t kMaxChannelLength = 63;     // LCM's limit
inline constexpr std::size_t kMaxEventData = 16u << 20;  // beyond this a length is taken for damage

// Damage of a log. `where`: byte and length.
struct LogDamage : Defect {
  Utime after = 0;  // time stamp of the last sound event before it, 0 where there is none
};

// Appends events to a new log. All calls are thread-safe. Every error is a DataError that names the
// file, the system's reason and what was kept; after the first one every further call throws it
// again.
//
// Write leaves the event in memory, and waits for no disk: Sync, once a second, brings it there. Of
// a disk that hangs, memory holds 64 MiB; then the record has failed. Only a record that grows
// faster than it is synced, on the virtual clock, is written by Write itself.
class EventLogWriter {
 public:
  // Throws DataError when the file exists already or cannot be made.
  explicit EventLogWriter(const std::filesystem::path& file);
  // Closes in silence: call Close to hear of errors.
  ~EventLogWriter();
  EventLogWriter(const EventLogWriter&) = delete;
  EventLogWriter& operator=(const EventLogWriter&) = delete;

  // `channel`: 1 to 63 printable characters.
  void Write(std::string_view channel, Utime utime, const std::uint8_t* data, std::size_t size);
  // Returns when all events written so far are on the disk.
  void Sync();
  // Sync, then the end: a Write after it throws.
  void Close();
  std::int64_t events() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// One event. The views hold until the next call of the reader.
struct LogEvent {
  Utime utime = 0;
  std::int64_t number = 0;  // as counted by the writer, without the checksum
  std::int64_t byte = 0;    // place of the sync word in the file
  std::string_view channel;
  std::span<const std::uint8_t> data;
};

// Reads a log in one pass, in memory bounded by the largest event (kMaxEventData), not by the
// length of the file. An event is handed out where its checksum holds; in a log that has none, one
// of another logger, where another event follows it. Damage is skipped up to the next event that
// may be believed, and reported. LCM's own reader is not used: it stops at the first bad length,
// and believes a length up to 2 GB.
class EventLogReader {
 public:
  // Throws DataError when the file cannot be opened.
  explicit EventLogReader(const std::filesystem::path& file);
  ~EventLogReader();
  EventLogReader(const EventLogReader&) = delete;
  EventLogReader& operator=(const EventLogReader&) = delete;

  // False at the end of the file. Throws DataError when the disk cannot be read.
  bool Next(LogEvent& event);
  // Of the file's bytes, 0..1.
  double fraction() const;
  // Damage found so far, one entry a stretch (`damaged_log`, its count the events that the
  // numbering says are lost, at least 1), `missing_events` where numbers jump in a sound file,
  // `truncated_log` where the last event is cut. After 100 entries the last one counts all further
  // ones.
  const std::vector<LogDamage>& damage() const { return damage_; }

 private:
  struct Header;
  bool Ensure(std::size_t bytes);
  std::size_t available() const { return tail_ - head_; }
  std::optional<Header> HeaderAt(std::size_t offset) const;
  std::optional<std::size_t> NextHeader(std::size_t from, std::size_t to) const;
  bool IsWhole(const Header& header);
  bool IsFollowed(std::size_t size) const;
  bool EndsTruncated(const std::optional<Header>& header);
  void SkipDamage();
  void CloseDamage(std::int64_t end_byte, std::int64_t events_lost);
  void CheckNumber(const Header& header);
  void Report(std::string kind, std::int64_t count, std::string where);

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::int64_t file_size_ = 0;
  std::vector<std::uint8_t> buffer_;
  std::size_t head_ = 0, tail_ = 0;  // of the unread bytes in buffer_
  std::int64_t head_byte_ = 0;       // place of head_ in the file
  std::size_t consumed_ = 0;         // size of the event last handed out
  Utime last_utime_ = 0;             // its time stamp
  bool has_checksums_ = false;       // of the log: one was right
  std::optional<std::int64_t> damage_begin_;
  std::optional<std::int64_t> next_number_;
  std::vector<LogDamage> damage_;
};

}  // namespace gyrobench::recording
