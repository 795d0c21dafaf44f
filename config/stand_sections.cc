#include "config/stand_sections.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>

namespace gyrobench::config {
namespace {

// A channel name of LCM has at most 63 characters; the longest suffix is _MODEL_RESULT.
constexpr std::size_t kMaxPrefix = 63 - std::string_view("_MODEL_RESULT").size();

void CheckChannelPrefix(const TomlTable& table, std::string_view prefix) {
  const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
  const auto allowed = [&](char c) { return is_upper(c) || (c >= '0' && c <= '9') || c == '_'; };
  if (!is_upper(prefix.front()) || !std::ranges::all_of(prefix, allowed) ||
      prefix.size() > kMaxPrefix) {
    table.Fail("channel_prefix",
               fmt::format("expected A-Z, 0-9 and _ with a letter first, at most {} characters "
                           "(with _MODEL_RESULT a channel of LCM may have 63)",
                           kMaxPrefix));
  }
}

// udpm://ADDRESS:PORT with anything after a "?", or LCM's own default where nothing is said. LCM
// itself is no help with a wrong one: it complains once a second, and is taken for a missing route.
bool IsMulticastUrl(std::string_view url) {
  constexpr std::string_view kScheme = "udpm://";
  if (!url.starts_with(kScheme)) return false;
  url = url.substr(kScheme.size(), url.find('?') - kScheme.size());
  if (url.empty()) return true;
  const std::size_t colon = url.rfind(':');
  if (colon == std::string_view::npos) return false;
  in_addr address{};
  if (inet_pton(AF_INET, std::string(url.substr(0, colon)).c_str(), &address) != 1 ||
      !IN_MULTICAST(ntohl(address.s_addr)))
    return false;
  const std::string_view port = url.substr(colon + 1);
  unsigned number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  return error == std::errc() && end == port.data() + port.size() && number >= 1 && number <= 65535;
}

}  // namespace

LcmConfig ReadLcm(const TomlTable& table) {
  LcmConfig lcm;
  lcm.url = table.String("url", lcm.url);
  if (!IsMulticastUrl(lcm.url) && !lcm.url.starts_with("memq://")) {
    table.Fail("url",
               "expected udpm://ADDRESS:PORT?ttl=N with a multicast address (224.0.0.0 to "
               "239.255.255.255) and a port of 1 to 65535, or memq:// for listeners inside the "
               "daemon");
  }
  lcm.channel_prefix = table.String("channel_prefix", lcm.channel_prefix);
  CheckChannelPrefix(table, lcm.channel_prefix);
  lcm.required = table.Bool("required", lcm.required);
  return lcm;
}

VirtualConfig ReadVirtual(const TomlTable& table) {
  VirtualConfig config;
  config.scenario = table.Path("scenario");
  if (!std::filesystem::is_regular_file(config.scenario)) {
    table.Fail("scenario", fmt::format("{}: no such file; config/scenarios has some",
                                       config.scenario.string()));
  }
  config.seed = static_cast<std::uint64_t>(
      table.Integer("seed", {0, std::numeric_limits<std::int64_t>::max()}, 1));
  config.pace = table.Number("pace", {0, 1e6, "s/s"}, config.pace);
  config.idle_pace = table.Number("idle_pace", {0, 1e6, "s/s"}, config.idle_pace);
  config.truth = table.OptionalPath("truth");
  config.wired_as = table.OptionalPath("wired_as");
  if (const auto answers = table.OptionalTable("answers")) {
    for (const std::string& id : answers->Keys()) config.answers[id] = answers->String(id);
  }
  return config;
}

}  // namespace gyrobench::config
