#include "presentation/markup.h"

#include <fmt/format.h>

#include <boost/locale/utf.hpp>
#include <utility>

namespace gyrobench::presentation {
namespace {

using Utf8 = boost::locale::utf::utf_traits<char>;
constexpr std::string_view kReplacement = "\xEF\xBF\xBD";  // U+FFFD

bool IsShown(boost::locale::utf::code_point point) {
  const bool control = point < 0x20 || (point >= 0x7F && point < 0xA0);
  // U+202A..E and U+2066..9 turn the direction of what follows; XML has no U+FFFE and U+FFFF.
  const bool turns = (point >= 0x202A && point <= 0x202E) || (point >= 0x2066 && point <= 0x2069);
  return boost::locale::utf::is_valid_codepoint(point) && !control && !turns && point != 0xFFFE &&
         point != 0xFFFF;
}

std::string_view Entity(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {};
  }
}

}  // namespace

std::string CleanText(std::string_view text) {
  std::string clean;
  clean.reserve(text.size());
  for (const char* at = text.data(); at != text.data() + text.size();) {
    const char* begin = at;
    if (*at == '\n' || *at == '\t' || *at == '\r') {
      clean += ' ';
      ++at;
      continue;
    }
    const auto point = Utf8::decode(at, text.data() + text.size());
    if (IsShown(point)) {
      clean.append(begin, at);
    } else {
      clean += kReplacement;
      if (at == begin) ++at;
    }
  }
  return clean;
}

std::string CleanLines(std::string_view text) {
  std::string clean;
  for (;;) {
    const std::size_t end = text.find('\n');
    clean += CleanText(text.substr(0, end));
    if (end == std::string_view::npos) return clean;
    clean += '\n';
    text.remove_prefix(end + 1);
  }
}

Markup Markup::Text(std::string_view text) {
  Markup markup;
  for (const char c : CleanText(text)) {
    const std::string_view entity = Entity(c);
    if (entity.empty()) {
      markup.html_ += c;
    } else {
      markup.html_ += entity;
    }
  }
  return markup;
}

Markup Markup::Trusted(std::string html) {
  Markup markup;
  markup.html_ = std::move(html);
  return markup;
}

Markup& Markup::operator+=(const Markup& more) {
  html_ += more.html_;
  return *this;
}

Markup Element(std::string_view tag, const Markup& inside, std::string_view css_class) {
  const std::string attribute = css_class.empty() ? "" : fmt::format(" class=\"{}\"", css_class);
  const bool block = tag != "td" && tag != "th" && tag != "span" && tag != "b" && tag != "code";
  return Markup::Trusted(
      fmt::format("<{0}{1}>{2}</{0}>{3}", tag, attribute, inside.html(), block ? "\n" : ""));
}

Markup Element(std::string_view tag, std::string_view text, std::string_view css_class) {
  return Element(tag, Markup::Text(text), css_class);
}

Markup CodeElement(std::string_view text) {
  constexpr std::size_t kMostInOneLine = 40;
  return Element("code", text, text.size() > kMostInOneLine ? "long" : "");
}

}  // namespace gyrobench::presentation
