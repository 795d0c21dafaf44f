#include <fmt/format.h>

#include <algorithm>

#include "presentation/charter.h"
#include "presentation/document.h"
#include "presentation/markup.h"
#include "presentation/number.h"

namespace gyrobench::presentation {
namespace {

Markup MarkupOf(const Piece& piece) {
  switch (piece.kind) {
    case Piece::Kind::kStrong:
      return Element("b", piece.text);
    case Piece::Kind::kCode:
      return CodeElement(piece.text);
    case Piece::Kind::kNumber:
      return Markup::Text(Typeset(piece.text));
    case Piece::Kind::kUnit:
      return Markup::Text(TypesetUnit(piece.text));
    case Piece::Kind::kWords:
      break;
  }
  return Markup::Text(TypesetPowers(piece.text));
}

Markup MarkupOf(const Text& text) {
  Markup written;
  for (const Piece& piece : text.pieces()) written += MarkupOf(piece);
  return written;
}

// Of a cell that breaks between its words: no line ends within a number.
Markup BrokenBesideNumbers(const Text& text) {
  Markup written;
  for (const Piece& piece : text.pieces()) {
    const bool number = piece.kind == Piece::Kind::kNumber;
    written += number ? Element("span", MarkupOf(piece), "number") : MarkupOf(piece);
  }
  return written;
}

// Of several parts each has a look of its own: the axis, and what is said of it.
Markup Title(const Text& text) {
  if (text.pieces().size() < 2) return MarkupOf(text);
  Markup title;
  for (const Piece& piece : text.pieces()) {
    const bool words = piece.kind == Piece::Kind::kWords;
    title += piece.kind == Piece::Kind::kStrong ? Element("span", piece.text, "axis")
             : words                            ? Element("span", piece.text, "word")
                                                : MarkupOf(piece);
  }
  return title;
}

class PageRenderer {
 public:
  explicit PageRenderer(Charter& charter) : charter_(charter) {}

  Markup Rendered(const Document& document, int depth) {
    Markup page;
    for (const Block& block : document)
      page += std::visit([&](const auto& one) { return Rendered(one, depth); }, block.content);
    return page;
  }

 private:
  static Markup Rendered(const Paragraph& paragraph, int) {
    return Element("p", MarkupOf(paragraph.text), paragraph.role);
  }

  static Markup Rendered(const Table& table, int) {
    std::vector<std::vector<std::string>> columns(table.columns.size());
    for (std::size_t i = 0; i < table.columns.size(); ++i) {
      for (const Row& row : table.rows) {
        if (row.names_group) continue;
        const Text cell = i < row.cells.size() ? row.cells[i] : Text();
        columns[i].push_back(
            (IsRight(table.columns[i]) ? MarkupOf(cell) : BrokenBesideNumbers(cell)).html());
      }
      if (table.columns[i].kind == Column::Kind::kNumber) AlignDecimals(columns[i]);
    }
    Markup rows;
    std::size_t next = 0;
    for (const Row& row : table.rows) {
      rows += Element(
          "tr",
          row.names_group ? Group(row, table.columns.size()) : CellsOf(table, columns, next++),
          row.names_group ? "group" : "");
    }
    // Scrolls where it is too wide for the page.
    return Element("div", Element("table", Head(table) + Element("tbody", rows), table.role),
                   "table");
  }

  static Markup Group(const Row& row, std::size_t columns) {
    return Markup::Trusted(
        fmt::format("<td colspan=\"{}\">{}</td>", columns, MarkupOf(row.cells.front()).html()));
  }

  static Markup CellsOf(const Table& table, const std::vector<std::vector<std::string>>& columns,
                        std::size_t row) {
    Markup cells;
    for (std::size_t i = 0; i < columns.size(); ++i)
      cells += Element("td", Markup::Trusted(columns[i][row]), Class(table.columns[i]));
    return cells;
  }

  static Markup Head(const Table& table) {
    Markup head;
    bool any = false;
    for (const Column& column : table.columns) {
      head += Element("th", column.title, Class(column));
      any = any || !column.title.empty();
    }
    return any ? Element("thead", Element("tr", head)) : Markup();
  }

  static bool IsRight(const Column& column) {
    return column.kind == Column::Kind::kNumber || column.kind == Column::Kind::kCount;
  }
  static const char* Class(const Column& column) { return IsRight(column) ? "number" : ""; }

  static Markup Rendered(const Facts& facts, int) {
    Markup list;
    for (const Fact& fact : facts.facts) {
      Markup text = MarkupOf(fact.text);
      if (!fact.detail.empty()) text += Element("p", MarkupOf(fact.detail), "note");
      list += Element("dt", MarkupOf(fact.name)) + Element("dd", text);
    }
    return Element("dl", list);
  }

  static Markup Rendered(const List& list, int) {
    Markup items;
    for (const Text& item : list.items) items += Element("li", MarkupOf(item));
    return Element("ul", items);
  }

  static Markup Rendered(const Comparisons& comparisons, int) {
    Markup cells;
    for (const Comparison& one : comparisons.figures) {
      const Text what = one.note.empty() ? one.name : one.name + " (" + one.note + ")";
      const Text unit = one.unit.empty() ? Text() : " " + Unit(one.unit);
      cells += Element("div", Element("p", MarkupOf(what), "what") +
                                  Element("p", MarkupOf(one.figure) + MarkupOf(unit), "figure") +
                                  Element("p", MarkupOf(one.change), "interval"));
    }
    return Element("div", cells, "figures");
  }

  Markup Rendered(const Charts& charts, int) {
    Markup figures, not_drawn;
    for (const Chart& chart : charts.charts) {
      const auto [figure, why_not] = charter_.Draw(chart);
      figures += figure;
      if (!why_not.empty()) not_drawn += Element("li", chart.title + ": " + why_not);
    }
    Markup notes;
    if (!not_drawn.empty())
      notes = Element("p", "Not drawn:", "no-chart") + Element("ul", not_drawn);
    return Element("div", figures, "charts") + notes;
  }

  Markup Rendered(const Section& section, int depth) {
    static constexpr const char* kHeadings[] = {"h2", "h3", "h4"};
    static constexpr const char* kParts[] = {"section", "div", "article"};
    const int level = std::min(depth, 2);
    const Markup heading =
        section.title.empty() ? Markup() : Element(kHeadings[level], Title(section.title));
    return Element(kParts[level], heading + Rendered(section.blocks, depth + 1), section.role);
  }

  Charter& charter_;
};

}  // namespace

Markup RenderPage(const Document& document, Charter& charter) {
  return PageRenderer(charter).Rendered(document, 0);
}

}  // namespace gyrobench::presentation
