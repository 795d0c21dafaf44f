#include "recording/decimal_commas.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "base/error.h"

namespace gyrobench::recording {
namespace {

constexpr std::int64_t kFewest = 3;

bool IsPartOfNumber(std::string_view field) {
  while (!field.empty() && (field.front() == '"' || field.front() == ' ' || field.front() == '-' ||
                            field.front() == '+'))
    field.remove_prefix(1);
  while (!field.empty() && (field.back() == '"' || field.back() == ' ' || field.back() == '\r'))
    field.remove_suffix(1);
  return std::ranges::all_of(field, [](unsigned char c) { return std::isdigit(c) != 0; });
}

}  // namespace

void DecimalCommas::Look(std::string_view line, std::int64_t line_number, std::size_t columns) {
  constexpr std::size_t kShown = 60;
  std::size_t fields = 0;
  for (std::string_view rest = line;;) {
    const std::size_t comma = rest.find(',');
    if (!IsPartOfNumber(rest.substr(0, comma))) return;
    ++fields;
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (fields <= columns || fields > 2 * columns) return;
  if (found_++ == 0) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    first_ = fmt::format("{}:{}: found '{}{}', which has {} fields where the header has {} columns",
                         file_, line_number, line.substr(0, kShown),
                         line.size() > kShown ? "..." : "", fields, columns);
  }
  if (found_ >= kFewest && found_ > accepted_) Refuse();
}

void DecimalCommas::End() const {
  if (found_ > accepted_) Refuse();
}

void DecimalCommas::Refuse() const {
  throw DataError(fmt::format(
      "{}: its numbers have decimal commas. Accepted are numbers with a point, such as 0.01, and a "
      "comma between two fields: save the table with '.' as its decimal mark",
      first_));
}

}  // namespace gyrobench::recording
