// Text for a terminal: its width, aligned tables, a bar, a small plot. No colour codes but by
// Terminal.
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::presentation {

// What one output stream can show.
struct Terminal {
  bool is_terminal = false;
  bool redraws = false;  // a terminal that knows more than lines: TERM is set and not dumb
  bool colour = false;   // such a terminal, and NO_COLOR is not set
  int columns = 80;

  // `text` in bold, in red or dimmed where colour may be used.
  std::string Bold(std::string_view text) const;
  std::string Red(std::string_view text) const;
  std::string Dim(std::string_view text) const;
};

// Of a file descriptor; columns from the terminal, else from COLUMNS, else 80.
Terminal DescribeTerminal(int descriptor);

// Columns that UTF-8 text takes (one a code point; colour codes none).
int DisplayWidth(std::string_view text);

// `text` cut to `columns`, the last one "…" where something was cut. No colour codes within.
std::string Shorten(std::string_view text, int columns);

// Each line of `text` cut to the terminal's width; all of it where there is no terminal.
std::string FitLines(std::string_view text, const Terminal& terminal);

// `text` broken between words to `columns`, each line but the first indented by `indent`.
std::string Wrap(std::string_view text, int columns, int indent);

// Texts are broken at this width also where there is no terminal.
inline constexpr int kTextColumns = 100;

// `text` broken to the terminal's width, at most kTextColumns, all lines indented and those after
// the first by two more. Ends in a newline.
std::string WrappedParagraph(const std::string& text, const Terminal& terminal, int indent);

// The lines of a text, without their ends.
std::vector<std::string> LinesOf(const std::string& text);

enum class Align { kLeft, kRight };

// Rows of cells as aligned columns, two spaces between, no trailing spaces; `indent` before each
// line. A row may have fewer cells than `align` has entries. Each line ends in a newline.
std::string AlignColumns(const std::vector<std::vector<std::string>>& rows,
                         const std::vector<Align>& align, int indent = 0);

// A row as several: its last cell broken between words to `columns`, beneath empty cells.
std::vector<std::vector<std::string>> BreakLastCell(std::vector<std::string> row, int columns);

// Pictures next to each other, each line padded to the widest of its picture; two spaces between.
std::string SideBySide(const std::vector<std::string>& pictures);

// "████████▌░░░░" `columns` wide; `fraction` is held to 0..1, NaN is 0.
std::string Bar(double fraction, int columns);

// A curve y(x) over x_min..x_max as a picture in braille dots with both axes labelled, `columns` by
// `rows` characters in all. Values that are not finite are left out; empty when none is finite.
struct Plot {
  std::string x_label, y_label;
  double x_min = 0.0, x_max = 1.0;
  std::function<double(double)> y;
  int columns = 70;
  int rows = 10;
};
std::string DrawPlot(const Plot& plot);

// Points (x[i], y[i]) in the same way, over their range.
struct PointPlot {
  std::string x_label, y_label;
  std::vector<double> x, y;
  int columns = 70;
  int rows = 10;
};
std::string DrawPoints(const PointPlot& plot);

}  // namespace gyrobench::presentation
