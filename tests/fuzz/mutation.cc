#include "tests/fuzz/mutation.h"

#include <bit>
#include <cstdint>
#include <limits>
#include <sstream>
#include <vector>

namespace gyrobench::testing {
namespace {

constexpr const char* kNumbers[] = {"nan",
                                    "inf",
                                    "-inf",
                                    "1e308",
                                    "-1e308",
                                    "1e-308",
                                    "-0",
                                    "0",
                                    "1e9",
                                    "-1e9",
                                    "1e18",
                                    "1e400",
                                    "32767",
                                    "-32768",
                                    "1e300",
                                    "1e-320",
                                    "",
                                    "0x7fff",
                                    "9223372036854775807"};

std::size_t Below(Random& random, std::size_t size) { return size == 0 ? 0 : random() % size; }

std::vector<std::string> Split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) parts.push_back(part);
  if (!text.empty() && text.back() == separator) parts.emplace_back();
  return parts;
}

std::string Join(const std::vector<std::string>& parts, char separator) {
  std::string text;
  for (std::size_t i = 0; i < parts.size(); ++i)
    text += (i > 0 ? std::string(1, separator) : "") + parts[i];
  return text;
}

std::size_t HeaderLine(const std::vector<std::string>& lines) {
  std::size_t header = 0;
  while (header + 1 < lines.size() && lines[header].starts_with('#')) ++header;
  return header;
}

void RemoveColumn(std::vector<std::string>& lines, std::size_t header, Random& random) {
  const std::size_t column = Below(random, Split(lines[header], ',').size());
  for (std::size_t i = header; i < lines.size(); ++i) {
    std::vector<std::string> fields = Split(lines[i], ',');
    if (column < fields.size()) fields.erase(fields.begin() + static_cast<std::ptrdiff_t>(column));
    lines[i] = Join(fields, ',');
  }
}

// One field, or the same field of all further lines.
void ReplaceField(std::vector<std::string>& lines, std::size_t begin, std::size_t end,
                  Random& random) {
  const std::size_t column = Below(random, Split(lines[begin], ',').size());
  const char* number = kNumbers[Below(random, std::size(kNumbers))];
  for (std::size_t i = begin; i < end; ++i) {
    std::vector<std::string> fields = Split(lines[i], ',');
    if (column < fields.size()) fields[column] = number;
    lines[i] = Join(fields, ',');
  }
}

void PutBigEndian(std::string& bytes, std::size_t at, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) {
    bytes[at + i] = static_cast<char>(value >> (8 * (size - 1 - i)));
  }
}

}  // namespace

void MutateBytes(std::string& bytes, Random& random) {
  if (bytes.empty()) return;
  const std::size_t at = Below(random, bytes.size());
  switch (random() % 6) {
    case 0:
      bytes[at] = static_cast<char>(random());
      break;
    case 1:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      break;
    case 2:
      bytes.erase(at, random() % 200 + 1);
      break;
    case 3:
      bytes.insert(at, bytes.substr(Below(random, bytes.size()), random() % 300));
      break;
    case 4:
      bytes.insert(at, random() % 20, static_cast<char>(random()));
      break;
    default:
      bytes.resize(at);
      break;
  }
}

void MutateTable(std::string& text, Random& random) {
  std::vector<std::string> lines = Split(text, '\n');
  if (lines.empty()) return;
  const std::size_t header = HeaderLine(lines);
  const std::size_t line = header + Below(random, lines.size() - header);
  const auto place = lines.begin() + static_cast<std::ptrdiff_t>(line);
  switch (random() % 9) {
    case 0:
      lines.insert(place, *place);
      break;
    case 1:
      std::swap(lines[line], lines[Below(random, lines.size())]);
      break;
    case 2:
      lines.erase(place, place + static_cast<std::ptrdiff_t>(Below(
                                     random, std::min<std::size_t>(40, lines.size() - line))));
      break;
    case 3:
    case 4:
      ReplaceField(lines, line, line + 1, random);
      break;
    case 5:
      ReplaceField(lines, line, lines.size(), random);
      break;
    case 6:
      RemoveColumn(lines, header, random);
      break;
    case 7:
      lines.insert(place, std::string(lines[header]));
      break;
    default:
      lines.insert(place, 1 + random() % 100, std::string(*place));
      break;
  }
  text = Join(lines, '\n');
}

void MutateBinaryNumber(std::string& bytes, Random& random) {
  constexpr double kDoubles[] = {std::numeric_limits<double>::quiet_NaN(),
                                 std::numeric_limits<double>::infinity(),
                                 1e308,
                                 -1e308,
                                 1e-308,
                                 -0.0,
                                 1e18};
  constexpr std::uint64_t kIntegers[] = {0,
                                         1,
                                         0x7fff,
                                         0x7fff'ffff,
                                         0xffff'ffff,
                                         0x7fff'ffff'ffff'ffff,
                                         0x8000'0000'0000'0000,
                                         0xffff'ffff'ffff'ffff};
  constexpr std::size_t kSizes[] = {2, 4, 8};
  if (bytes.size() < 16) return;
  const std::size_t at = Below(random, bytes.size() - 8);
  if (random() % 2 == 0) {
    const double number = kDoubles[Below(random, std::size(kDoubles))];
    return PutBigEndian(bytes, at, std::bit_cast<std::uint64_t>(number), 8);
  }
  PutBigEndian(bytes, at, kIntegers[Below(random, std::size(kIntegers))], kSizes[random() % 3]);
}

void MutateTextNumber(std::string& text, Random& random) {
  constexpr const char* kDigits = "0123456789";
  const std::size_t begin = text.find_first_of(kDigits, Below(random, text.size()));
  if (begin == std::string::npos) return;
  const std::size_t end = std::min(text.find_first_not_of("0123456789.eE", begin), text.size());
  text.replace(begin, end - begin, kNumbers[Below(random, std::size(kNumbers))]);
}

}  // namespace gyrobench::testing
