// What commands print that is no document of presentation/: errors, and tables of what a daemon or
// a record says, in the width of the terminal.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "presentation/text_layout.h"

namespace gyrobench::cli {

// "gyrobench COMMAND: TEXT" on stderr, broken to the width of a terminal; a log gets one line.
// Where no command was given `command` is empty.
void PrintError(const std::string& command, std::string_view text);

// Rows of cells as columns that are aligned to the left, two spaces between, `indent` before each
// line. The text in the last column is broken between words, so that no line is wider than the
// terminal, or than presentation::kTextColumns where there is none; what is too wide without a
// space in it, as a path, stays whole. `columns`: of the table; a row may have fewer cells, and is
// not broken then.
std::string WrappedColumns(const std::vector<std::vector<std::string>>& rows, std::size_t columns,
                           const presentation::Terminal& terminal, int indent = 0);

}  // namespace gyrobench::cli
