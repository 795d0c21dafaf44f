#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "presentation/charter.h"

namespace gyrobench::presentation {
namespace {

void EraseElement(std::string& svg, const std::string& tag) {
  const std::string open = "<" + tag + ">", close = "</" + tag + ">";
  for (std::size_t at = svg.find(open); at != std::string::npos; at = svg.find(open, at)) {
    const std::size_t end = svg.find(close, at);
    if (end == std::string::npos) return;
    svg.erase(at, end + close.size() - at);
  }
}

void ReplaceAll(std::string& text, std::string_view from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at)) {
    text.replace(at, from.size(), to);
    at += to.size();
  }
}

void EraseAttribute(std::string& tag, const std::string& name) {
  const std::string start = name + "=\"";
  for (std::size_t at = tag.find(start); at != std::string::npos; at = tag.find(start, at)) {
    const std::size_t end = tag.find('"', at + start.size());
    if (end == std::string::npos) return;
    tag.erase(at, end + 1 - at);
  }
}

// Ids and what refers to them; attributes that a page has no use for.
std::string CleanTag(std::string tag, const std::string& prefix) {
  for (const char* name : {"xmlns", "xmlns:xlink", "font-family"}) EraseAttribute(tag, name);
  for (const char* quote : {"'", "\""}) {
    ReplaceAll(tag, std::string(" id=") + quote, std::string(" id=") + quote + prefix);
    ReplaceAll(tag, std::string(" xlink:href=") + quote + "#",
               std::string(" href=") + quote + "#" + prefix);
  }
  ReplaceAll(tag, "url(#", "url(#" + prefix);
  return tag;
}

// A bare > in text is legal but for "]]>".
void AppendText(std::string_view text, std::string& out) {
  for (const char c : text) {
    if (c == '>') {
      out += "&gt;";
    } else {
      out += c;
    }
  }
}

}  // namespace

Markup InlineSvg(const std::string& svg, const std::string& prefix, const std::string& label) {
  const std::size_t begin = svg.find("<svg"), end = svg.rfind("</svg>");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return {};
  std::string whole = svg.substr(begin, end + 6 - begin);
  EraseElement(whole, "title");
  EraseElement(whole, "desc");
  std::string page;
  for (std::size_t at = 0; at < whole.size();) {
    const std::size_t close = whole.find('>', at);
    if (close == std::string::npos) return {};
    page += CleanTag(whole.substr(at, close + 1 - at), prefix);
    at = std::min(whole.find('<', close), whole.size());
    AppendText(std::string_view(whole).substr(close + 1, at - close - 1), page);
  }
  page.insert(4, fmt::format(" role=\"img\" aria-label=\"{}\"", Markup::Text(label).html()));
  return Markup::Trusted(page + "\n");
}

}  // namespace gyrobench::presentation
