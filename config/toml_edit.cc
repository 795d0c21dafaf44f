#include "config/toml_edit.h"

#include <fmt/format.h>

#include <cstddef>
#include <optional>

#include "config/toml_document.h"

namespace gyrobench::config {
namespace {

std::vector<std::string> LinesOf(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

std::string Joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string Trimmed(std::string_view line) {
  const std::size_t comment = line.find('#');
  if (comment != std::string_view::npos) line = line.substr(0, comment);
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return std::string(line.substr(first, line.find_last_not_of(" \t\r") - first + 1));
}

struct Key {
  std::string table, name;
};

Key Split(const std::string& dotted) {
  const std::size_t dot = dotted.rfind('.');
  if (dot == std::string::npos) return {"", dotted};
  return {dotted.substr(0, dot), dotted.substr(dot + 1)};
}

std::optional<std::size_t> HeadOf(const std::string& table, const std::vector<std::string>& lines) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string head = Trimmed(lines[i]);
    std::erase(head, ' ');
    std::erase(head, '\t');
    if (head == fmt::format("[{}]", table)) return i;
  }
  return std::nullopt;
}

// Above the first key of its table; as a dotted key under the table around it, where the file
// speaks of it so; else under a head of its own at the end.
void Insert(const toml::table& root, const TomlEdit& edit, std::vector<std::string>* lines) {
  Key key = Split(edit.key);
  const std::string table = key.table;
  const bool known = table.empty() || root.at_path(table).is_table();
  std::size_t place = 0;
  while (!key.table.empty()) {
    if (const auto head = HeadOf(key.table, *lines)) {
      place = *head + 1;
      break;
    }
    if (!known) {
      lines->insert(lines->end(), {"", fmt::format("[{}]", key.table)});
      place = lines->size();
      break;
    }
    const Key outer = Split(key.table);
    key = {outer.table, fmt::format("{}.{}", outer.name, key.name)};
  }
  lines->insert(lines->begin() + static_cast<std::ptrdiff_t>(place),
                {"# " + edit.comment, fmt::format("{} = {}", key.name, edit.value)});
}

// Of the column that toml++ gives, which counts characters from 1.
std::size_t ByteOf(const std::string& line, std::size_t column) {
  std::size_t byte = 0;
  for (std::size_t character = 1; byte < line.size(); ++byte) {
    const bool begins = (static_cast<unsigned char>(line[byte]) & 0xC0U) != 0x80U;
    if (begins && character++ == column) return byte;
  }
  return byte;
}

std::string EditedOnce(const std::string& text, const std::filesystem::path& file,
                       const TomlEdit& edit) {
  const auto document = Parse(text, file);
  const toml::node_view<const toml::node> node = document->root.at_path(edit.key);
  std::vector<std::string> lines = LinesOf(text);
  if (!node || !node.is_value()) {
    Insert(document->root, edit, &lines);
    return Joined(lines);
  }
  const toml::source_region& region = node.node()->source();
  const std::size_t at = region.begin.line - 1;
  std::string& line = lines.at(at);
  const std::size_t begin = ByteOf(line, region.begin.column);
  line.replace(begin, ByteOf(line, region.end.column) - begin, edit.value);
  const std::string indent = line.substr(0, line.find_first_not_of(" \t"));
  lines.insert(lines.begin() + static_cast<std::ptrdiff_t>(at), indent + "# " + edit.comment);
  return Joined(lines);
}

}  // namespace

std::string Edited(std::string_view text, const std::filesystem::path& file,
                   const std::vector<TomlEdit>& edits) {
  std::string edited(text);
  for (const TomlEdit& edit : edits) edited = EditedOnce(edited, file, edit);
  Parse(edited, file);
  return edited;
}

std::string EditedFile(const std::filesystem::path& file, const std::vector<TomlEdit>& edits) {
  return Edited(ReadWholeFile(file), file, edits);
}

}  // namespace gyrobench::config
