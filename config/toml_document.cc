#include "config/toml_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>

#include "base/error.h"
#include "base/nearest_word.h"

namespace gyrobench::config {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMaxShownValue = 60;

// What to write where line `number` (from 1) of `text` gives a number a decimal comma; or empty.
std::string CommaHint(std::string_view text, toml::source_index number) {
  for (; number > 1 && !text.empty(); --number)
    text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  std::string_view line = text.substr(0, text.find_first_of("\r\n#"));
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return "";
  line.remove_prefix(std::min(line.find_first_not_of(" \t", equals + 1), line.size()));
  line = line.substr(0, line.find_last_not_of(" \t") + 1);
  const auto point = WithDecimalPoint(line);
  return point ? fmt::format("; write {}", *point) : "";
}

// The library makes a table for each part of a dotted key, one in the other, and takes them apart
// by calling itself once a level.
void CheckDepth(std::string_view text, const fs::path& file) {
  constexpr int kMostParts = 100;
  int dots = 0, line = 1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    const std::string_view here = text.substr(i, 3);
    if (here == "\"\"\"" || here == "'''") {  // text of several lines
      const std::size_t end = std::min(text.find(here, i + 3), text.size());
      line += static_cast<int>(std::ranges::count(text.substr(i, end - i), '\n'));
      i = end + 2;
      continue;
    }
    if (c == '"' || c == '\'') {  // a quoted part; one that is not closed in its line is none
      const std::size_t end = text.find_first_of(c == '"' ? "\"\n" : "'\n", i + 1);
      if (end != std::string_view::npos && text[end] == c) i = end;
      continue;
    }
    if (c == '#') {
      i = std::min(text.find('\n', i), text.size()) - 1;
      continue;
    }
    if (std::string_view("\n,=[]{}").find(c) != std::string_view::npos) dots = 0;
    if (c != '.' || ++dots < kMostParts) continue;
    throw ConfigError(
        fmt::format("{}:{}: a key of more than {} parts", file.string(), line, kMostParts));
  }
}

}  // namespace

std::string Place(const fs::path& file, const toml::source_region& region) {
  return fmt::format("{}:{}", file.string(), std::max(region.begin.line, toml::source_index{1}));
}

std::string ReadWholeFile(const fs::path& file) {
  std::error_code error;
  if (fs::is_directory(file, error)) {
    throw ConfigError(fmt::format("{}: is a folder; expected a TOML file", file.string()));
  }
  std::ifstream in(file, std::ios::binary);
  if (!in)
    throw ConfigError(fmt::format("{}: cannot be opened: {}", file.string(), std::strerror(errno)));
  std::ostringstream text;
  if (in.peek() != std::ifstream::traits_type::eof()) text << in.rdbuf();
  if (in.bad() || !text) throw ConfigError(fmt::format("{}: cannot be read", file.string()));
  return text.str();
}

std::shared_ptr<const Document> Parse(std::string_view text, const fs::path& file) {
  auto document = std::make_shared<Document>();
  document->file = file;
  CheckDepth(text, file);
  try {
    document->root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    throw ConfigError(fmt::format("{}, column {}: not valid TOML: {}{}",
                                  Place(file, error.source()), error.source().begin.column,
                                  error.description(), CommaHint(text, error.source().begin.line)));
  }
  return document;
}

std::string ShowValue(const toml::node& node) {
  std::ostringstream out;
  const auto flags =
      toml::toml_formatter::default_flags & ~toml::format_flags::allow_literal_strings;
  out << toml::toml_formatter{node, flags};
  std::string text = out.str();
  std::replace(text.begin(), text.end(), '\n', ' ');
  if (text.size() <= kMaxShownValue) return text;
  std::size_t size = kMaxShownValue;
  const auto is_inside_character = [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) == 0x80;
  };
  while (size > 0 && is_inside_character(text[size])) --size;  // UTF-8
  text.resize(size);
  return text + " ...";
}

}  // namespace gyrobench::config
