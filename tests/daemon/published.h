// What was published on LCM, where the address is that of a file: for tests of what listeners hear.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace gyrobench::daemon {

// The address at which LCM writes to `file` what is published.
inline std::string LcmUrlOf(const std::filesystem::path& file) {
  return "file://" + file.string() + "?mode=w";
}

struct Published {
  std::string channel;
  std::vector<std::uint8_t> bytes;

  bool operator==(const Published&) const = default;
};

// All events of a log of LCM, in their order, without who sent them. What was published is whole
// once the publisher is gone.
std::vector<Published> EventsOf(const std::filesystem::path& log);

// Those of one channel, decoded; without those that are not whole.
template <typename Message>
std::vector<Message> MessagesOn(const std::string& channel, const std::vector<Published>& events) {
  std::vector<Message> messages;
  for (const Published& event : events) {
    if (event.channel != channel) continue;
    const int size = static_cast<int>(event.bytes.size());
    Message& message = messages.emplace_back();
    if (message.decode(event.bytes.data(), 0, size) != size) messages.pop_back();
  }
  return messages;
}

}  // namespace gyrobench::daemon
