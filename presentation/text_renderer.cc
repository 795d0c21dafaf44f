#include <algorithm>
#include <limits>
#include <utility>

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

constexpr int kNoLimit = std::numeric_limits<int>::max();

// A table as lines of cells; a note stands beside its row where there is room, else beneath it.
class Layout {
 public:
  // Without a terminal a line is as long as its row, and no longer than `most` columns anywhere.
  Layout(const Table& table, const Terminal& terminal, int indent, int most = kNoLimit)
      : table_(table),
        terminal_(terminal),
        indent_(indent),
        most_(terminal.is_terminal ? std::min(terminal.columns, most) : most) {
    Cells head;
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      if (table.columns[i].page_only) continue;
      shown_.push_back(i);
      head.push_back(table.columns[i].title);
      const bool right = table.columns[i].kind == Column::Kind::kCount;
      align_.push_back(right ? Align::kRight : Align::kLeft);
    }
    if (std::ranges::any_of(head, [](const auto& title) { return !title.empty(); }))
      head_ = std::move(head);
    for (const Row& row : table.rows) rows_.push_back(CellsOf(row));
  }

  // Each row in its line where that is narrow enough; empty where it is not.
  std::string Beside() const {
    const std::string text = Lines(head_, [&](const Cells& cells) { return Printed{{cells}, ""}; });
    return Fits(text) ? text : "";
  }

  // Notes broken within their column, or beneath their rows where that is too narrow; empty where
  // the table has none or is too wide without them as well.
  std::string WithNotesBroken() const {
    constexpr int kNarrowestNote = 24;
    if (!HasNotes()) return "";
    const int room = most_ - WidthWithoutNotes();
    const std::string text =
        room < kNarrowestNote
            ? Lines(WithoutNote(head_), [&](const Cells& cells) { return NoteBeneath(cells); })
            : Lines(head_, [&](const Cells& cells) {
                return Printed{BreakLastCell(cells, room), ""};
              });
    return Fits(text) ? text : "";
  }

  // The cells of each row one below the other, each after its title; those without one together, as
  // a number and its unit. The unit of several numbers stands beside the name.
  std::string Stacked() const {
    std::string text = head_.empty() ? "" : Paragraph(head_.front(), 0);
    for (const Cells& row : rows_) {
      const bool unit = table_.splits && row.size() > 1 && row.back() != "1" && !row.back().empty();
      text += Paragraph(unit ? row.front() + ", " + row.back() : row.front(), 0);
      std::string together;
      for (std::size_t i = 1; i + (table_.splits ? 1 : 0) < row.size(); ++i) {
        const std::string title = head_.empty() ? "" : head_[i];
        const bool alone = !title.empty() || IsNote(i);
        if (alone) text += Paragraph(std::exchange(together, ""), 2);
        if (row[i].empty() || row[i] == "-") continue;
        if (alone) {
          text += Paragraph(title.empty() ? row[i] : title + ": " + row[i], 2);
        } else {
          together += (together.empty() ? "" : " ") + row[i];
        }
      }
      text += Paragraph(together, 2);
    }
    return text;
  }

 private:
  struct Printed {
    std::vector<Cells> lines;  // aligned with those of the other rows
    std::string beneath;       // follows as it is
  };

  Cells CellsOf(const Row& row) const {
    if (row.names_group) return {Written(row.cells.front(), terminal_)};
    Cells cells;
    for (const std::size_t column : shown_)
      cells.push_back(column < row.cells.size() ? Written(row.cells[column], terminal_) : "");
    return cells;
  }
  std::string Paragraph(const std::string& text, int more) const {
    return text.empty() ? "" : WrappedParagraph(text, terminal_, indent_ + more);
  }
  bool IsNote(std::size_t i) const { return table_.columns[shown_[i]].kind == Column::Kind::kNote; }
  bool HasNotes() const { return shown_.size() > 1 && IsNote(shown_.size() - 1); }
  bool NamesGroup(std::size_t row) const { return table_.rows[row].names_group; }

  int WidthWithoutNotes() const {
    int width = indent_;
    for (std::size_t i = 0; i + 1 < shown_.size(); ++i) {
      int widest = head_.empty() ? 0 : DisplayWidth(head_[i]);
      for (std::size_t row = 0; row < rows_.size(); ++row)
        if (!NamesGroup(row)) widest = std::max(widest, DisplayWidth(rows_[row][i]));
      width += widest + 2;
    }
    return width;
  }
  static Cells WithoutNote(Cells cells) {
    if (!cells.empty()) cells.back().clear();
    return cells;
  }
  Printed NoteBeneath(const Cells& cells) const {
    const std::string title = head_.empty() || cells.back().empty() ? "" : head_.back();
    return {{WithoutNote(cells)},
            Paragraph(title.empty() ? cells.back() : title + ": " + cells.back(), 4)};
  }

  template <typename Print>
  std::string Lines(const Cells& head, const Print& print) const {
    std::vector<Cells> aligned;
    if (!head.empty()) aligned.push_back(head);
    std::vector<Printed> printed;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      printed.push_back(NamesGroup(i) ? Printed{{}, Paragraph(rows_[i].front(), 0)}
                                      : print(rows_[i]));
      aligned.insert(aligned.end(), printed.back().lines.begin(), printed.back().lines.end());
    }
    const std::vector<std::string> lines = LinesOf(AlignColumns(aligned, align_, indent_));
    std::size_t next = 0;
    std::string text = head.empty() ? "" : lines[next++] + "\n";
    for (const Printed& row : printed) {
      for (std::size_t i = 0; i < row.lines.size(); ++i) text += lines[next++] + "\n";
      text += row.beneath;
    }
    return text;
  }
  bool Fits(const std::string& text) const {
    return std::ranges::all_of(LinesOf(text),
                               [&](const auto& line) { return DisplayWidth(line) <= most_; });
  }

  const Table& table_;
  const Terminal& terminal_;
  int indent_, most_;
  std::vector<std::size_t> shown_;  // columns of the table
  std::vector<Align> align_;
  Cells head_;  // empty: no column has a title
  std::vector<Cells> rows_;
};

bool IsKnown(const Row& row, std::size_t column) {
  return column < row.cells.size() && row.cells[column].Plain() != "-" &&
         !row.cells[column].empty();
}

// One column of numbers with the names before and the units behind it; rows that have no number
// are left out.
Table OneColumn(const Table& table, std::size_t column) {
  Table narrow{{table.columns.front(), table.columns[column], table.columns.back()}, {}};
  for (const Row& row : table.rows)
    if (IsKnown(row, column)) narrow.Add({row.cells.front(), row.cells[column], row.cells.back()});
  return narrow;
}

// Its columns of numbers one below the other; empty where they are too wide as well.
std::string Split(const Table& table, const Terminal& terminal, int indent) {
  std::string text;
  for (std::size_t i = 1; table.splits && i + 1 < table.columns.size(); ++i) {
    const Table column = OneColumn(table, i);
    if (column.rows.empty()) continue;
    const std::string lines = Layout(column, terminal, indent).Beside();
    if (lines.empty()) return "";
    text += lines;
  }
  return text;
}

// Nothing is left out for want of room, and no cell is cut.
std::string Rendered(const Table& table, const Terminal& terminal, int indent,
                     int most = kNoLimit) {
  const Layout layout(table, terminal, indent, most);
  for (const std::string& text :
       {layout.Beside(), Split(table, terminal, indent), layout.WithNotesBroken()})
    if (!text.empty()) return text;
  return layout.Stacked();
}

std::string Rendered(const Paragraph& paragraph, const Terminal& terminal, int indent) {
  return WrappedParagraph(Written(paragraph.text, terminal), terminal, indent);
}

std::string Rendered(const Facts& facts, const Terminal& terminal, int indent) {
  std::string text;
  for (const Fact& fact : facts.facts) {
    const Text line = fact.text.empty() ? fact.name : fact.name + ": " + fact.text;
    text += WrappedParagraph(Written(line, terminal), terminal, indent);
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
  Table table{{{}, {}, {}, {"", Column::Kind::kNote}}, {}};
  for (const Comparison& one : comparisons.figures)
    table.Add({one.name, one.figure, one.unit, Join({one.change, one.note}, "; ")});
  return Rendered(table, terminal, indent, kTextColumns);  // their notes are sentences
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
