// The bytes of a logged message, checked before they reach generated code. lcm-gen's decoder takes
// counts and string lengths from the bytes as they are: a damaged one makes it reserve gigabytes,
// or read past the end.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace gyrobench::recording {

using MessageBytes = std::span<const std::uint8_t>;

// Whether all counts and lengths in a message of the type fit its size.
bool IsSoundGyro(MessageBytes bytes);
bool IsSoundAngle(MessageBytes bytes);
bool IsSoundRun(MessageBytes bytes);

// Decodes sound bytes. False when they are another type, another version or damaged.
template <typename Message>
bool Decode(MessageBytes bytes, bool (*is_sound)(MessageBytes), Message& message) {
  if (!is_sound(bytes)) return false;
  const int size = static_cast<int>(bytes.size());
  return message.decode(bytes.data(), 0, size) == size;
}

}  // namespace gyrobench::recording
