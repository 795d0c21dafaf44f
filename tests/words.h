// What a text says, for tests that ask neither for its lines nor for where they end.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace gyrobench {

inline std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

// Words as they follow each other, wherever lines end.
inline std::string Flat(const std::string& text) {
  std::istringstream stream(text);
  std::string flat;
  for (std::string word; stream >> word;) flat += (flat.empty() ? "" : " ") + word;
  return flat;
}

// How often `part` stands in a text.
inline int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size())
    ++count;
  return count;
}

}  // namespace gyrobench
