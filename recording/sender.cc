#include "recording/sender.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <random>
#include <string_view>

namespace gyrobench::recording {
namespace {

constexpr std::string_view kMark = "GYROBNCH";
constexpr std::size_t kDigits = 16;

}  // namespace

Sender DrawSender() {
  std::random_device device;
  std::uniform_int_distribution<std::uint64_t> any;
  return {any(device)};
}

std::string Name(Sender sender) { return fmt::format("{:016x}", sender.id); }

std::optional<Sender> SenderNamed(const std::string& name) {
  Sender sender;
  const char* const end = name.data() + name.size();
  const auto [stopped, error] = std::from_chars(name.data(), end, sender.id, 16);
  if (name.size() != kDigits || error != std::errc() || stopped != end) return std::nullopt;
  return sender;
}

SenderBytes BytesOf(Sender sender) {
  SenderBytes bytes{};
  std::ranges::copy(kMark, bytes.begin());
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[15 - i] = static_cast<std::uint8_t>(sender.id >> (8 * i) & 0xFF);
  }
  return bytes;
}

std::optional<Sender> SenderOf(MessageBytes bytes) {
  if (bytes.size() < SenderBytes().size()) return std::nullopt;
  const MessageBytes last = bytes.last(SenderBytes().size());
  if (!std::ranges::equal(last.first(kMark.size()), kMark)) return std::nullopt;
  Sender sender;
  for (const std::uint8_t byte : last.subspan(kMark.size())) sender.id = sender.id << 8 | byte;
  return sender;
}

}  // namespace gyrobench::recording
