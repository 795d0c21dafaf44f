#include "presentation/document.h"

#include <iterator>
#include <utility>

namespace gyrobench::presentation {

Text::Text(std::string words) { Add({Piece::Kind::kWords, std::move(words)}); }

void Text::Add(Piece piece) {
  if (!piece.text.empty()) pieces_.push_back(std::move(piece));
}

Text& Text::operator+=(const Text& more) {
  pieces_.insert(pieces_.end(), more.pieces_.begin(), more.pieces_.end());
  return *this;
}

std::string Text::Plain() const {
  std::string plain;
  for (const Piece& piece : pieces_) plain += piece.text;
  return plain;
}

Text Strong(std::string text) { return Text(Piece{Piece::Kind::kStrong, std::move(text)}); }
Text Code(std::string text) { return Text(Piece{Piece::Kind::kCode, std::move(text)}); }
Text Number(std::string text) { return Text(Piece{Piece::Kind::kNumber, std::move(text)}); }
Text Unit(std::string text) { return Text(Piece{Piece::Kind::kUnit, std::move(text)}); }

Text Quantity(const std::string& number, const std::string& unit) {
  if (unit.empty() || unit == "1" || number == "-") return Number(number);
  return Number(number + " ") + Unit(unit);
}

Text Join(const std::vector<Text>& parts, const std::string& separator) {
  Text joined;
  for (const Text& part : parts) {
    if (part.empty()) continue;
    if (!joined.empty()) joined += separator;
    joined += part;
  }
  return joined;
}

List ListOf(const std::vector<std::string>& items) { return {{items.begin(), items.end()}}; }

void Add(Document& document, Paragraph paragraph) {
  if (!paragraph.text.empty()) document.push_back({std::move(paragraph)});
}
void Add(Document& document, Table table) {
  if (!table.rows.empty()) document.push_back({std::move(table)});
}
void Add(Document& document, Facts facts) {
  if (!facts.facts.empty()) document.push_back({std::move(facts)});
}
void Add(Document& document, List list) {
  if (!list.items.empty()) document.push_back({std::move(list)});
}
void Add(Document& document, Comparisons comparisons) {
  if (!comparisons.figures.empty()) document.push_back({std::move(comparisons)});
}
void Add(Document& document, Charts charts) {
  if (!charts.charts.empty()) document.push_back({std::move(charts)});
}
void Add(Document& document, Section section) {
  if (!section.blocks.empty()) document.push_back({std::move(section)});
}
void Add(Document& document, Document more) {
  document.insert(document.end(), std::make_move_iterator(more.begin()),
                  std::make_move_iterator(more.end()));
}

}  // namespace gyrobench::presentation
