#include "cli/terminal_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace gyrobench::cli {
namespace {

// A last column narrower than this is left to the terminal.
constexpr int kLeastColumns = 20;

}  // namespace

void PrintError(const std::string& command, std::string_view text) {
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stderr));
  const std::string line =
      fmt::format("gyrobench{}{}: {}", command.empty() ? "" : " ", command, text);
  fmt::print(stderr, "{}\n",
             terminal.is_terminal ? presentation::Wrap(line, terminal.columns, 2) : line);
}

std::string WrappedColumns(const std::vector<std::vector<std::string>>& rows, std::size_t columns,
                           const presentation::Terminal& terminal, int indent) {
  int begin = indent;  // of the last column
  for (std::size_t i = 0; i + 1 < columns; ++i) {
    int width = 0;
    for (const auto& row : rows)
      if (i < row.size()) width = std::max(width, presentation::DisplayWidth(row[i]));
    begin += width + 2;
  }
  const int widest = terminal.is_terminal ? std::min(terminal.columns, presentation::kTextColumns)
                                          : presentation::kTextColumns;
  const int left = std::max(kLeastColumns, widest - begin);
  std::vector<std::vector<std::string>> broken;
  for (const auto& row : rows) {
    if (row.size() == columns) {
      std::ranges::move(presentation::BreakLastCell(row, left), std::back_inserter(broken));
    } else {
      broken.push_back(row);
    }
  }
  return presentation::AlignColumns(
      broken, std::vector<presentation::Align>(columns, presentation::Align::kLeft), indent);
}

}  // namespace gyrobench::cli
