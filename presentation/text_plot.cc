#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "presentation/number.h"
#include "presentation/text_layout.h"

namespace gyrobench::presentation {
namespace {

// Dots of braille characters: 2 across and 4 down in each.
class Canvas {
 public:
  Canvas(int columns, int rows)
      : columns_(columns), rows_(rows), cells_(static_cast<std::size_t>(columns * rows), 0U) {}
  int columns() const { return columns_; }
  int rows() const { return rows_; }
  int dots_across() const { return columns_ * 2; }
  int dots_down() const { return rows_ * 4; }

  void Set(int x, int y) {
    // Unicode numbers the dots 1-3 down the left, 4-6 down the right, 7 and 8 below.
    static constexpr unsigned kBits[4][2] = {
        {0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
    cells_[static_cast<std::size_t>((y / 4) * columns_ + x / 2)] |= kBits[y % 4][x % 2];
  }

  std::string Row(int row) const {
    std::string text;
    for (int column = 0; column < columns_; ++column) {
      const unsigned code = 0x2800U + cells_[static_cast<std::size_t>(row * columns_ + column)];
      text += static_cast<char>(0xE0U | (code >> 12U));
      text += static_cast<char>(0x80U | ((code >> 6U) & 0x3FU));
      text += static_cast<char>(0x80U | (code & 0x3FU));
    }
    return text;
  }

 private:
  int columns_, rows_;
  std::vector<unsigned> cells_;
};

struct Range {
  double low = HUGE_VAL, high = -HUGE_VAL;
};

Range FiniteRange(const std::vector<double>& values) {
  Range range;
  for (const double value : values) {
    if (!std::isfinite(value)) continue;
    range.low = std::min(range.low, value);
    range.high = std::max(range.high, value);
  }
  if (range.high - range.low < 1e-12 * std::max(1.0, std::abs(range.high))) {
    range.low -= 0.5;
    range.high += 0.5;
  }
  return range;
}

// Joins neighbours of a steep curve by a vertical line of dots.
void DrawCurve(Canvas& canvas, const std::vector<double>& values, const Range& range) {
  int last = -1;
  for (int x = 0; x < canvas.dots_across(); ++x) {
    const double value = values[static_cast<std::size_t>(x)];
    if (!std::isfinite(value)) {
      last = -1;
      continue;
    }
    const double up = (value - range.low) / (range.high - range.low);
    const int y = static_cast<int>(std::lround((1.0 - up) * (canvas.dots_down() - 1)));
    const int from = last < 0 ? y : std::min(y, last), to = last < 0 ? y : std::max(y, last);
    for (int dot = from; dot <= to; ++dot) canvas.Set(x, dot);
    last = y;
  }
}

// Two digits below the span of the curve, so that both labels differ.
constexpr int kLabelColumns = 9;

Canvas CanvasFor(int columns, int rows) {
  return {std::max(10, columns - kLabelColumns - 2), std::max(2, rows - 2)};
}

struct Labels {
  std::string x, y;
};

std::string Framed(const Canvas& canvas, const Labels& labels, const Range& across,
                   const Range& up) {
  std::string text = fmt::format("{:>{}} {}\n", "", kLabelColumns, labels.y);
  for (int row = 0; row < canvas.rows(); ++row) {
    std::string label;
    if (row == 0) label = FormatNumber(up.high, 4);
    if (row == canvas.rows() - 1) label = FormatNumber(up.low, 4);
    text += fmt::format("{:>{}} {}{}\n", label, kLabelColumns, label.empty() ? "│" : "┤",
                        canvas.Row(row));
  }
  const std::string left = FormatNumber(across.low, 4), right = FormatNumber(across.high, 4);
  const int middle = canvas.columns() - DisplayWidth(left) - DisplayWidth(right);
  const std::string label = DisplayWidth(labels.x) + 2 <= middle ? labels.x : "";
  const int before = std::max(1, (middle - DisplayWidth(label)) / 2);
  const int after = std::max(1, middle - before - DisplayWidth(label));
  return text + fmt::format("{:>{}} {}{:{}}{}{:{}}{}\n", "", kLabelColumns, left, "", before, label,
                            "", after, right);
}

}  // namespace

std::string SideBySide(const std::vector<std::string>& pictures) {
  std::vector<std::vector<std::string>> rows;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::vector<std::string> lines = LinesOf(pictures[i]);
    if (rows.size() < lines.size()) rows.resize(lines.size());
    for (std::size_t row = 0; row < lines.size(); ++row) {
      rows[row].resize(i + 1);
      rows[row][i] = lines[row];
    }
  }
  return AlignColumns(rows, std::vector<Align>(pictures.size(), Align::kLeft));
}

std::string DrawPlot(const Plot& plot) {
  Canvas canvas = CanvasFor(plot.columns, plot.rows);
  std::vector<double> values(static_cast<std::size_t>(canvas.dots_across()));
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(values.size() - 1);
    values[i] = plot.y(plot.x_min + part * (plot.x_max - plot.x_min));
  }
  const Range range = FiniteRange(values);
  if (!(range.low < range.high)) return "";
  DrawCurve(canvas, values, range);
  return Framed(canvas, {plot.x_label, plot.y_label}, {plot.x_min, plot.x_max}, range);
}

std::string DrawPoints(const PointPlot& plot) {
  Canvas canvas = CanvasFor(plot.columns, plot.rows);
  const Range across = FiniteRange(plot.x), up = FiniteRange(plot.y);
  if (!(across.low < across.high) || !(up.low < up.high)) return "";
  const auto dot = [](double value, const Range& range, int dots) {
    return static_cast<int>(
        std::lround((value - range.low) / (range.high - range.low) * (dots - 1)));
  };
  for (std::size_t i = 0; i < plot.x.size(); ++i) {
    if (!std::isfinite(plot.x[i]) || !std::isfinite(plot.y[i])) continue;
    canvas.Set(dot(plot.x[i], across, canvas.dots_across()),
               canvas.dots_down() - 1 - dot(plot.y[i], up, canvas.dots_down()));
  }
  return Framed(canvas, {plot.x_label, plot.y_label}, across, up);
}

}  // namespace gyrobench::presentation
