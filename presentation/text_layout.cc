#include "presentation/text_layout.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace gyrobench::presentation {
namespace {

std::string Coloured(bool colour, std::string_view code, std::string_view text) {
  if (!colour) return std::string(text);
  return fmt::format("\x1b[{}m{}\x1b[0m", code, text);
}

bool BeginsCodePoint(char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }

int Columns(int descriptor) {
  winsize size{};
  if (ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  if (const char* columns = std::getenv("COLUMNS")) {
    const int n = std::atoi(columns);
    if (n > 0) return n;
  }
  return 80;
}

// Of the first one; the groups of a number, "1 234 567", are one word.
std::size_t EndOfWord(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789";
  const auto end_after = [&](std::size_t begin) {
    return std::min(text.find_first_of(" \n", begin), text.size());
  };
  const auto is_digit = [&](std::size_t i) {
    return i < text.size() && kDigits.find(text[i]) != kDigits.npos;
  };
  std::size_t end = end_after(0);
  while (end > 0 && end < text.size() && text[end] == ' ' && is_digit(end - 1) &&
         is_digit(end + 1) && is_digit(end + 2) && is_digit(end + 3) && !is_digit(end + 4))
    end = end_after(end + 1);
  return end;
}

}  // namespace

std::string Terminal::Bold(std::string_view text) const { return Coloured(colour, "1", text); }
std::string Terminal::Red(std::string_view text) const { return Coloured(colour, "31", text); }
std::string Terminal::Dim(std::string_view text) const { return Coloured(colour, "2", text); }

Terminal DescribeTerminal(int descriptor) {
  Terminal terminal;
  terminal.is_terminal = isatty(descriptor) == 1;
  const char* no_colour = std::getenv("NO_COLOR");
  const char* term = std::getenv("TERM");
  const bool dumb = term == nullptr || std::string_view(term) == "dumb";
  terminal.redraws = terminal.is_terminal && !dumb;
  terminal.colour = terminal.redraws && (no_colour == nullptr || *no_colour == '\0');
  terminal.columns = std::max(20, Columns(descriptor));
  return terminal;
}

int DisplayWidth(std::string_view text) {
  int width = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\x1b') {
      const std::size_t end = text.find('m', i);
      if (end == std::string_view::npos) break;
      i = end;
    } else if (BeginsCodePoint(text[i])) {
      ++width;
    }
  }
  return width;
}

std::string Shorten(std::string_view text, int columns) {
  if (DisplayWidth(text) <= columns) return std::string(text);
  if (columns <= 0) return "";
  int left = columns;
  std::size_t end = 0;
  while (end < text.size() && (left > 1 || !BeginsCodePoint(text[end]))) {
    if (BeginsCodePoint(text[end])) --left;
    ++end;
  }
  return std::string(text.substr(0, end)) + "…";
}

std::string FitLines(std::string_view text, const Terminal& terminal) {
  if (!terminal.is_terminal) return std::string(text);
  std::string fitted;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    fitted += Shorten(text.substr(0, end), terminal.columns) + "\n";
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return fitted;
}

std::string Wrap(std::string_view text, int columns, int indent) {
  std::string wrapped;
  int used = 0;
  while (!text.empty()) {
    const std::size_t end = EndOfWord(text);
    const std::string_view word = text.substr(0, end);
    const int width = DisplayWidth(word);
    if (used > 0 && used + 1 + width > columns) {
      wrapped += "\n" + std::string(static_cast<std::size_t>(indent), ' ');
      used = indent;
    } else if (used > 0) {
      wrapped += ' ';
      ++used;
    }
    wrapped += word;
    used += width;
    if (end < text.size() && text[end] == '\n') {
      wrapped += "\n" + std::string(static_cast<std::size_t>(indent), ' ');
      used = 0;
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return wrapped;
}

std::string WrappedParagraph(const std::string& text, const Terminal& terminal, int indent) {
  const int columns =
      terminal.is_terminal ? std::min(terminal.columns, kTextColumns) : kTextColumns;
  return std::string(static_cast<std::size_t>(indent), ' ') +
         Wrap(text, columns - indent, indent + 2) + "\n";
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::vector<std::vector<std::string>> BreakLastCell(std::vector<std::string> row, int columns) {
  const std::vector<std::string> lines = LinesOf(Wrap(row.back(), columns, 0));
  std::vector<std::vector<std::string>> rows(std::max<std::size_t>(lines.size(), 1),
                                             std::vector<std::string>(row.size()));
  for (std::size_t i = 0; i < lines.size(); ++i) rows[i].back() = lines[i];
  std::move(row.begin(), row.end() - 1, rows.front().begin());
  return rows;
}

std::string AlignColumns(const std::vector<std::vector<std::string>>& rows,
                         const std::vector<Align>& align, int indent) {
  std::vector<int> widths(align.size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) {
      widths[i] = std::max(widths[i], DisplayWidth(row[i]));
    }
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line(static_cast<std::size_t>(indent), ' ');
    for (std::size_t i = 0; i < row.size() && i < widths.size(); ++i) {
      const auto pad = static_cast<std::size_t>(widths[i] - DisplayWidth(row[i]));
      if (i > 0) line += "  ";
      if (align[i] == Align::kRight) line.append(pad, ' ');
      line += row[i];
      if (align[i] == Align::kLeft) line.append(pad, ' ');
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string Bar(double fraction, int columns) {
  static constexpr std::array<const char*, 8> kEighths = {"", "▏", "▎", "▍", "▌", "▋", "▊", "▉"};
  const double held = std::isnan(fraction) ? 0.0 : std::clamp(fraction, 0.0, 1.0);
  const int eighths = static_cast<int>(std::floor(held * columns * 8));
  std::string bar;
  for (int i = 0; i < eighths / 8; ++i) bar += "█";
  const char* part = kEighths[static_cast<std::size_t>(eighths % 8)];
  bar += part;
  const int used = eighths / 8 + (*part != '\0' ? 1 : 0);
  for (int i = used; i < columns; ++i) bar += "░";
  return bar;
}

}  // namespace gyrobench::presentation
