// HTML by parts. Text and markup are two types, so that a file name or a device's answer cannot
// become markup by accident. Everything made here is well-formed XML as well.
#pragma once

#include <string>
#include <string_view>

namespace gyrobench::presentation {

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

// The same of each line; the lines stay.
std::string CleanLines(std::string_view text);

// <tag class="css_class">inside</tag>; without a class where it is empty.
Markup Element(std::string_view tag, const Markup& inside, std::string_view css_class = {});
Markup Element(std::string_view tag, std::string_view text, std::string_view css_class = {});

// Breaks between its characters where it is long.
Markup CodeElement(std::string_view text);

}  // namespace gyrobench::presentation
