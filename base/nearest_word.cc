#include "base/nearest_word.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

namespace gyrobench {
namespace {

// Longer words are cut: what differs beyond is no slip of the pen, and time grows with the square.
constexpr std::size_t kMaxLength = 100;

// Edit distance, but a word without its beginning or its end (max_rate for max_rate_deg_s) is near.
int Distance(std::string_view word, std::string_view known) {
  constexpr std::size_t kShortest = 3;
  constexpr int kPart = 2;
  const bool is_part = (word.size() >= kShortest && known.find(word) != std::string_view::npos) ||
                       (known.size() >= kShortest && word.find(known) != std::string_view::npos);
  const int distance = EditDistance(word, known);
  return is_part ? std::min(distance, kPart) : distance;
}

}  // namespace

int EditDistance(std::string_view a, std::string_view b) {
  a = a.substr(0, kMaxLength);
  b = b.substr(0, kMaxLength);
  // Rows i - 2, i - 1 and i of the table of distances between prefixes.
  std::array<std::vector<int>, 3> rows;
  for (auto& row : rows) row.resize(b.size() + 1);
  std::iota(rows[1].begin(), rows[1].end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    const auto& before = rows[(i + 2) % 3];
    const auto& above = rows[i % 3];
    auto& row = rows[(i + 1) % 3];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int differs = a[i - 1] == b[j - 1] ? 0 : 1;
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + differs});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return rows[(a.size() + 1) % 3][b.size()];
}

std::string Suggestion(std::string_view word, const std::vector<std::string>& known) {
  if (known.empty()) return "no key is known here";
  const auto nearer = [&](const std::string& a, const std::string& b) {
    return Distance(word, a) < Distance(word, b);
  };
  const auto nearest = std::min_element(known.begin(), known.end(), nearer);
  const int distance = Distance(word, *nearest);
  const int length = static_cast<int>(std::max(word.size(), nearest->size()));
  std::string list = fmt::format("known here: \"{}\"", fmt::join(known, "\", \""));
  const bool far = distance > length / 2;
  // A command that was not meant, as "stop" for "history", is worse than none.
  if (3 * distance > 2 * length || (far && !nearest->starts_with(word.substr(0, 1)))) return list;
  const std::string meant = fmt::format("did you mean \"{}\"?", *nearest);
  return far ? fmt::format("{} ({})", meant, list) : meant;
}

}  // namespace gyrobench
