#include "recording/message_bytes.h"

#include <cstddef>

#include "gyrobench/reflection.hpp"

namespace gyrobench::recording {
namespace {

// Walks over the fields of one message without reading their values.
class Walk {
 public:
  explicit Walk(MessageBytes bytes) : left_(bytes) { Skip(8); }  // the type's hash

  void Skip(std::size_t bytes) {
    sound_ = sound_ && bytes <= left_.size();
    if (sound_) left_ = left_.subspan(bytes);
  }
  // The size of an array, a signed number of so many bytes.
  std::size_t Count(std::size_t bytes) {
    const std::span<const std::uint8_t> number = left_;
    Skip(bytes);
    sound_ = sound_ && number[0] < 0x80;
    std::size_t value = 0;
    for (std::size_t i = 0; sound_ && i < bytes; ++i) value = value << 8 | number[i];
    return value;
  }
  // A string's length counts its terminating zero.
  void String() {
    const std::size_t length = Count(4);
    sound_ = sound_ && length >= 1;
    Skip(length);
  }
  // All fields were there, and nothing after them.
  bool Ended() const { return sound_ && left_.empty(); }
  bool sound() const { return sound_; }

 private:
  MessageBytes left_;
  bool sound_ = true;
};

}  // namespace

template <typename Message>
bool DecodeSound(MessageBytes bytes, Message& message) {
  Walk walk(bytes);
  Reflection<Message>::Pass(walk);
  if (!walk.Ended()) return false;
  const int size = static_cast<int>(bytes.size());
  return message.decode(bytes.data(), 0, size) == size;
}

#define GYROBENCH_INSTANTIATE(Message) template bool DecodeSound(MessageBytes, Message&);
GYROBENCH_FOR_EACH_MESSAGE(GYROBENCH_INSTANTIATE)
#undef GYROBENCH_INSTANTIATE

}  // namespace gyrobench::recording
