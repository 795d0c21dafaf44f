// Fields of a table's line as text.
#pragma once

#include <string_view>

namespace gyrobench::recording {

// Without blanks and line ends at both ends.
inline std::string_view Trim(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

// Trimmed, and without the double quotes that spreadsheets put around a field.
inline std::string_view Unquote(std::string_view text) {
  text = Trim(text);
  if (text.size() < 2 || text.front() != '"' || text.back() != '"') return text;
  return Trim(text.substr(1, text.size() - 2));
}

}  // namespace gyrobench::recording
