// The bytes of a message, checked before they reach generated code. lcm-gen's decoder takes counts
// and string lengths from the bytes as they are: a damaged one makes it reserve gigabytes, or read
// past the end.
#pragma once

#include <cstdint>
#include <span>

namespace gyrobench::recording {

using MessageBytes = std::span<const std::uint8_t>;

// Decodes bytes in which all counts and lengths fit the size. False when they are another type,
// another version or damaged. Message: any type of msgs/.
template <typename Message>
bool DecodeSound(MessageBytes bytes, Message& message);

}  // namespace gyrobench::recording
