// What a result says, as data: built once from the typed result (results.h), written to a terminal
// or to a page.
#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "presentation/chart.h"

namespace gyrobench::presentation {

class Charter;
class Markup;
struct Terminal;

// A part of a text. Numbers and units are written as number.h does; a page typesets them.
struct Piece {
  enum class Kind { kWords, kStrong, kCode, kNumber, kUnit };
  Kind kind = Kind::kWords;
  std::string text;
};

class Text {
 public:
  Text() = default;
  Text(std::string words);                               // NOLINT: words are text
  Text(const char* words) : Text(std::string(words)) {}  // NOLINT: as above
  explicit Text(Piece piece) { Add(std::move(piece)); }

  Text& operator+=(const Text& more);
  friend Text operator+(Text left, const Text& right) { return left += right; }
  bool operator==(const Text& other) const { return Plain() == other.Plain(); }
  bool empty() const { return pieces_.empty(); }
  const std::vector<Piece>& pieces() const { return pieces_; }
  std::string Plain() const;  // without any difference between its parts

 private:
  void Add(Piece piece);
  std::vector<Piece> pieces_;
};

Text Strong(std::string text);
Text Code(std::string text);  // an id, an equation
Text Number(std::string text);
Text Unit(std::string text);
// "0.62 ± 0.01 deg": without the unit where that is empty, "1", or the number is missing.
Text Quantity(const std::string& number, const std::string& unit);
// "a, b or c" with the separator given; empty parts are left out.
Text Join(const std::vector<Text>& parts, const std::string& separator);

struct Paragraph {
  Text text;
  std::string role = {};  // how a page shows it: "note", "summary"
};

struct Column {
  enum class Kind {
    kText,
    kNumber,  // a page aligns them by their decimal points
    kCount,   // counts, durations: aligned on the right
    kNote,    // a terminal without room for it beside the row breaks it, or puts it beneath
  };
  std::string title = {};
  Kind kind = Kind::kText;
  bool page_only = false;
};

// Rows of cells; a row of one cell that names the rows below it where `names_group`.
struct Row {
  std::vector<Text> cells;
  bool names_group = false;
};

struct Table {
  std::vector<Column> columns;
  std::vector<Row> rows = {};
  // Between the first column and the last one stand numbers of one kind, as of the three axes: a
  // terminal that is too narrow shows them one below the other.
  bool splits = false;
  std::string role = {};  // how a page shows it: "files"
  void Add(std::vector<Text> cells) { rows.push_back({std::move(cells)}); }
};

// What, and what is said of it.
struct Fact {
  Text name, text;
  Text detail = {};  // for which a terminal has no room
};
struct Facts {
  std::vector<Fact> facts;
  void Add(Text name, Text text) {
    if (!text.empty()) facts.push_back({std::move(name), std::move(text), {}});
  }
};

struct List {
  std::vector<Text> items = {};
  // Of a terminal; without one an item stands two columns further right than what is around it.
  std::string marker = "- ";
};
List ListOf(const std::vector<std::string>& items);

// A figure before and after something was done about it.
struct Comparison {
  std::string name;
  Text figure, change;
  std::string unit;
  Text note;
};
struct Comparisons {
  std::vector<Comparison> figures;
};

struct Charts {
  std::vector<Chart> charts;
};

struct Block;
using Document = std::vector<Block>;

struct Section {
  Text title;
  Document blocks;
  std::string role = {};  // how a page shows it: "verdict explained"
};

struct Block {
  std::variant<Paragraph, Table, Facts, List, Comparisons, Charts, Section> content;
};

// Only what has something to say is added: no table without rows, no section without blocks.
void Add(Document& document, Paragraph paragraph);
void Add(Document& document, Table table);
void Add(Document& document, Facts facts);
void Add(Document& document, List list);
void Add(Document& document, Comparisons comparisons);
void Add(Document& document, Charts charts);
void Add(Document& document, Section section);
void Add(Document& document, Document more);

// On a terminal sections of the outermost level stand apart by an empty line; what is in a section
// stands two columns further right than its title. Each line ends in a newline.
std::string RenderText(const Document& document, const Terminal& terminal);
// On a page sections become <section> with <h2>, those in them <h3> and <h4>. Numbers and units are
// typeset, the columns of numbers aligned by their decimal points, charts drawn by `charter`.
Markup RenderPage(const Document& document, Charter& charter);

}  // namespace gyrobench::presentation
