// Who sent a message: the instance of the daemon, in bytes that follow the message on the wire and
// that no reader of LCM needs to know (docs/decisions/0013).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "recording/message_decoder.h"

namespace gyrobench::recording {

// Drawn at the start of a daemon, and the same in all that it publishes until it ends. It tells
// senders apart that mean no harm; it is no proof.
struct Sender {
  std::uint64_t id = 0;

  auto operator<=>(const Sender&) const = default;
};

// A new one.
Sender DrawSender();

// As the control socket and messages to people show it: 16 hexadecimal digits. The way back gives
// nothing where the text is not of that form.
std::string Name(Sender sender);
std::optional<Sender> SenderNamed(const std::string& name);

// "GYROBNCH", then the id, most significant byte first.
using SenderBytes = std::array<std::uint8_t, 16>;
SenderBytes BytesOf(Sender sender);

// Of the bytes of a whole message as they were received; nothing where they end otherwise: an older
// daemon, a log that is played back, another program.
std::optional<Sender> SenderOf(MessageBytes bytes);

}  // namespace gyrobench::recording
