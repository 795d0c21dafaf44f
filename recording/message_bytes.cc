#include "recording/message_bytes.h"

#include <cstddef>
#include <initializer_list>

namespace gyrobench::recording {

namespace {

// Walks over the fields of one message (msgs/*.lcm) without reading their values.
class Walk {
 public:
  explicit Walk(MessageBytes bytes) : left_(bytes) { Skip(8); }  // the type's hash

  Walk& Skip(std::size_t bytes) {
    sound_ = sound_ && bytes <= left_.size();
    if (sound_) left_ = left_.subspan(bytes);
    return *this;
  }
  std::int64_t Int32() {
    if (left_.size() < 4) sound_ = false;
    if (!sound_) return 0;
    const std::uint32_t value = std::uint32_t{left_[0]} << 24 | std::uint32_t{left_[1]} << 16 |
                                std::uint32_t{left_[2]} << 8 | std::uint32_t{left_[3]};
    Skip(4);
    return static_cast<std::int32_t>(value);
  }
  // A string's length counts its terminating zero.
  Walk& String() {
    const std::int64_t length = Int32();
    sound_ = sound_ && length >= 1;
    return sound_ ? Skip(static_cast<std::size_t>(length)) : *this;
  }
  // All fields were there, and nothing after them.
  bool Ended() const { return sound_ && left_.empty(); }
  bool sound() const { return sound_; }

 private:
  MessageBytes left_;
  bool sound_ = true;
};

}  // namespace

bool IsSoundGyro(MessageBytes bytes) {
  Walk walk(bytes);
  walk.Skip(8).String();                 // utime, run_id
  walk.Skip(8 + 8 + 8 + 4 + 8 + 8 + 8);  // seq ... accel_lsb_per_g
  const std::int64_t n = walk.Int32();
  walk.Skip(8);  // first_counter
  if (!walk.sound() || n < 0) return false;
  constexpr std::size_t kSampleBytes = 8 + 8 + 3 * 2 + 3 * 2 + 4;
  return walk.Skip(static_cast<std::size_t>(n) * kSampleBytes).Ended();
}

bool IsSoundAngle(MessageBytes bytes) {
  return Walk(bytes).Skip(8).String().Skip(8 + 1 + 8 + 8 + 8 + 8).Ended();
}

bool IsSoundRun(MessageBytes bytes) {
  Walk walk(bytes);
  walk.Skip(8).String().Skip(8 + 1);         // utime, run_id, seq, event
  walk.String().String().String();           // procedure, segment kind and name
  walk.Skip(8 + 4 + 8 + 8);                  // segment_begin_utime ... remaining_s
  walk.String().String().String().String();  // text, choices, outcome, record
  return walk.Ended();
}

}  // namespace gyrobench::recording
