// HTML by parts. Text and markup are two types, so that a file name or a device's answer cannot
// become markup by accident. Everything made here is well-formed XML as well.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace gyrobench::report {

class Markup {
 public:
  Markup() = default;
  // Any text, escaped. Bytes that are no UTF-8 and control characters show as U+FFFD.
  static Markup Text(std::string_view text);
  // Markup as it stands: literals of this room and charts that were checked, nothing else.
  static Markup Trusted(std::string html);

  Markup& operator+=(const Markup& more);
  friend Markup operator+(Markup left, const Markup& right) { return left += right; }
  const std::string& html() const { return html_; }
  bool empty() const { return html_.empty(); }

 private:
  std::string html_;
};

// Valid UTF-8 in one line: line breaks and tabs become spaces, what cannot be shown U+FFFD.
std::string CleanText(std::string_view text);

// <tag class="css_class">inside</tag>; without a class where it is empty.
Markup Element(std::string_view tag, const Markup& inside, std::string_view css_class = {});
Markup Element(std::string_view tag, std::string_view text, std::string_view css_class = {});

Markup Paragraph(std::string_view text, std::string_view css_class = {});
Markup Code(std::string_view text);
// Empty where there are no lines.
Markup BulletList(const std::vector<std::string>& lines);

// A table whose rows are added one by one.
class Table {
 public:
  struct Column {
    std::string title;
    bool numeric = false;
  };
  explicit Table(std::vector<Column> columns, std::string css_class = {});
  void AddRow(const std::vector<Markup>& cells);
  // A line across all columns that names the rows below it.
  void AddGroup(const Markup& title);
  bool empty() const { return rows_.empty(); }
  Markup ToMarkup() const;

 private:
  std::vector<Column> columns_;
  std::string css_class_;
  Markup rows_;
};

}  // namespace gyrobench::report
