#include "config/toml_edit.h"

#include <fmt/format.h>

#include <cstddef>

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

// Above the first key of the table, at its head, or at the end of all.
void Insert(const TomlEdit& edit, const std::string& line, std::vector<std::string>* lines) {
  const Key key = Split(edit.key);
  std::size_t place = 0;
  if (!key.table.empty()) {
    const std::string head = fmt::format("[{}]", key.table);
    while (place < lines->size() && Trimmed((*lines)[place]) != head) ++place;
    if (place == lines->size()) {
      lines->emplace_back();
      lines->push_back(head);
      place = lines->size() - 1;
    }
    ++place;
  }
  lines->insert(lines->begin() + static_cast<std::ptrdiff_t>(place), {"# " + edit.comment, line});
}

std::string EditedOnce(const std::string& text, const std::filesystem::path& file,
                       const TomlEdit& edit) {
  const auto document = Parse(text, file);
  const toml::node_view<const toml::node> node = document->root.at_path(edit.key);
  std::vector<std::string> lines = LinesOf(text);
  if (!node || !node.is_value()) {
    Insert(edit, fmt::format("{} = {}", Split(edit.key).name, edit.value), &lines);
    return Joined(lines);
  }
  const toml::source_region& region = node.node()->source();
  const std::size_t at = region.begin.line - 1;
  std::string& line = lines.at(at);
  line.replace(region.begin.column - 1, region.end.column - region.begin.column, edit.value);
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
