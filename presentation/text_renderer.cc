#include <algorithm>

#include "presentation/document.h"
#include "presentation/text_layout.h"

namespace gyrobench::presentation {
namespace {

using Cells = std::vector<std::string>;

std::string Written(const Text& text, const Terminal& terminal) {
  std::string written;
  for (const Piece& piece : text.pieces()) {
    written += piece.kind == Piece::Kind::kStrong ? terminal.Bold(piece.text) : piece.text;
  }
  return written;
}

// Columns of one table that a terminal shows, by their number.
using Shown = std::vector<std::size_t>;

Cells CellsOf(const Row& row, const Shown& shown, const Terminal& terminal) {
  Cells cells;
  for (const std::size_t column : shown)
    cells.push_back(column < row.cells.size() ? Written(row.cells[column], terminal) : "");
  return cells;
}

// A note stays only where it fits.
void DropNotes(std::vector<Cells>& rows, const Table& table, const Shown& shown,
               const Terminal& terminal, int indent) {
  if (!terminal.is_terminal || table.columns[shown.back()].kind != Column::Kind::kNote) return;
  int width = indent;
  for (std::size_t i = 0; i + 1 < shown.size(); ++i) {
    int widest = 0;
    for (const Cells& cells : rows) widest = std::max(widest, DisplayWidth(cells[i]));
    width += widest + 2;
  }
  for (Cells& cells : rows)
    if (width + DisplayWidth(cells.back()) > terminal.columns) cells.back().clear();
}

std::string Aligned(const Table& table, const Shown& shown, const Terminal& terminal, int indent) {
  std::vector<Cells> rows;
  Cells head;
  for (const std::size_t column : shown) head.push_back(table.columns[column].title);
  const bool has_head = std::ranges::any_of(head, [](const auto& title) { return !title.empty(); });
  if (has_head) rows.push_back(head);
  for (const Row& row : table.rows)
    if (!row.names_group) rows.push_back(CellsOf(row, shown, terminal));
  DropNotes(rows, table, shown, terminal, indent);
  const std::vector<std::string> lines =
      LinesOf(AlignColumns(rows, std::vector<Align>(shown.size(), Align::kLeft), indent));
  std::string text = has_head ? lines.front() + "\n" : "";
  std::size_t next = has_head ? 1 : 0;
  for (const Row& row : table.rows) {
    const std::string line = row.names_group ? std::string(static_cast<std::size_t>(indent), ' ') +
                                                   Written(row.cells.front(), terminal)
                                             : lines[next++];
    text += line + "\n";
  }
  return text;
}

bool IsKnown(const Row& row, std::size_t column) {
  return column < row.cells.size() && row.cells[column].Plain() != "-" &&
         !row.cells[column].empty();
}

// One column of numbers with the names before and the units behind it; rows that have no number
// are left out.
std::string OneColumn(const Table& table, std::size_t column, const Terminal& terminal,
                      int indent) {
  Table narrow = table;
  std::erase_if(narrow.rows,
                [&](const Row& row) { return !row.names_group && !IsKnown(row, column); });
  return Aligned(narrow, {0, column, table.columns.size() - 1}, terminal, indent);
}

std::string Rendered(const Table& table, const Terminal& terminal, int indent) {
  Shown shown;
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (!table.columns[i].page_only) shown.push_back(i);
  std::string text = Aligned(table, shown, terminal, indent);
  const auto lines = LinesOf(text);
  const bool too_wide = terminal.is_terminal && std::ranges::any_of(lines, [&](const auto& line) {
                          return DisplayWidth(line) > terminal.columns;
                        });
  if (too_wide && table.splits) {
    text.clear();
    for (std::size_t i = 1; i + 1 < table.columns.size(); ++i)
      text += OneColumn(table, i, terminal, indent);
  }
  return FitLines(text, terminal);
}

std::string Rendered(const Paragraph& paragraph, const Terminal& terminal, int indent) {
  return WrappedParagraph(Written(paragraph.text, terminal), terminal, indent);
}

std::string Rendered(const Facts& facts, const Terminal& terminal, int indent) {
  std::string text;
  for (const Fact& fact : facts.facts) {
    text += WrappedParagraph(Written(fact.name + ": " + fact.text, terminal), terminal, indent);
  }
  return text;
}

std::string Rendered(const List& list, const Terminal& terminal, int indent) {
  std::string text;
  if (list.marker.empty()) indent += 2;
  for (const Text& item : list.items)
    text += WrappedParagraph(list.marker + Written(item, terminal), terminal, indent);
  return text;
}

std::string Rendered(const Comparisons& comparisons, const Terminal& terminal, int indent) {
  Table table{{{}, {}, {}, {}, {"", Column::Kind::kNote}}, {}};
  for (const Comparison& one : comparisons.figures)
    table.Add({one.name, one.figure, one.unit, one.change, one.note});
  return Rendered(table, terminal, indent);
}

// The first curve of a chart between its points.
double Interpolated(const Curve& curve, double x) {
  const auto above = std::ranges::lower_bound(curve.x, x);
  if (above == curve.x.end()) return curve.y.back();
  const auto i = static_cast<std::size_t>(above - curve.x.begin());
  if (i == 0) return curve.y.front();
  const double part = (x - curve.x[i - 1]) / (curve.x[i] - curve.x[i - 1]);
  return curve.y[i - 1] + part * (curve.y[i] - curve.y[i - 1]);
}

std::string Picture(const Chart& chart, int columns) {
  const Curve& curve = chart.curves.front();
  Plot plot;
  plot.x_label = chart.x_label;
  plot.y_label = chart.y_label;
  plot.x_min = curve.x.front();
  plot.x_max = curve.x.back();
  plot.y = [&](double x) { return Interpolated(curve, x); };
  plot.columns = columns;
  plot.rows = 8;
  return DrawPlot(plot);
}

// As many next to each other as there is room for.
std::string Rendered(const Charts& charts, const Terminal& terminal, int) {
  constexpr int kNarrowest = 32, kWidest = 60;
  const int available = std::min(terminal.columns, 120);
  const int abreast = std::clamp(available / kNarrowest, 1, static_cast<int>(charts.charts.size()));
  const int columns = std::clamp(available / abreast - 3, kNarrowest - 3, kWidest);
  std::string text;
  std::vector<std::string> row;
  for (const Chart& chart : charts.charts) {
    row.push_back(Picture(chart, columns));
    if (static_cast<int>(row.size()) < abreast && &chart != &charts.charts.back()) continue;
    text += "\n" + SideBySide(row);
    row.clear();
  }
  return text;
}

std::string Rendered(const Document& document, const Terminal& terminal, int indent);

std::string Rendered(const Section& section, const Terminal& terminal, int indent) {
  const std::string title = Written(section.title, terminal);
  return WrappedParagraph(indent == 0 ? terminal.Bold(title) : title, terminal, indent) +
         Rendered(section.blocks, terminal, indent + 2);
}

std::string Rendered(const Document& document, const Terminal& terminal, int indent) {
  std::string text;
  bool after_section = false;
  for (const Block& block : document) {
    const bool section = std::holds_alternative<Section>(block.content);
    if (indent == 0 && !text.empty() && (section || after_section)) text += "\n";
    text +=
        std::visit([&](const auto& one) { return Rendered(one, terminal, indent); }, block.content);
    after_section = section;
  }
  return text;
}

}  // namespace

std::string RenderText(const Document& document, const Terminal& terminal) {
  return Rendered(document, terminal, 0);
}

}  // namespace gyrobench::presentation
