#include "presentation/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string_view>

#include "presentation/markup.h"

namespace gyrobench::presentation {
namespace {

// Drawing units; the page scales them. A wide chart is two narrow ones and the gap between them.
constexpr int kWideWidth = 820, kNarrowWidth = 400, kHeight = 230;
constexpr double kLeft = 76, kRight = 14, kBottom = 44, kTop = 30;
// Not "with yerrorbars": its markers erase the curves behind them.
constexpr const char* kBars = "with vectors nohead lc rgb '#123f5f' lw 1.1";
constexpr double kLegendTop = 4, kLabelX = 9;
// Characters of an axis label that fit a narrow chart.
constexpr std::size_t kLongestLabel = 44;
// More markers than these hide the line that they mark.
constexpr std::size_t kMostMarkers = 24;

// gnuplot evaluates nothing in single quotes; a quote in them is written twice. Neither are there
// line breaks to end the string (CleanText).
std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : CleanText(text)) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

std::string Shortened(const std::string& label) {
  std::string clean = CleanText(label);
  std::size_t characters = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const bool begins_character = (clean[i] & 0xC0) != 0x80;
    if (begins_character && ++characters > kLongestLabel) return clean.substr(0, i) + "…";
  }
  return clean;
}

bool IsDrawn(const Chart& chart, double x, double y) {
  if (!std::isfinite(x) || !std::isfinite(y)) return false;
  return !chart.log_axes || (x > 0.0 && y > 0.0);
}

std::size_t Size(const Curve& curve) { return std::min(curve.x.size(), curve.y.size()); }

std::size_t CountPoints(const Chart& chart, const Curve& curve) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < Size(curve); ++i) count += IsDrawn(chart, curve.x[i], curve.y[i]);
  return count;
}

// On log axes a bar that reaches zero would leave the chart; it ends at a tenth of the value.
double LowEnd(const Chart& chart, double y, double error) {
  return chart.log_axes ? std::max(y - error, 0.1 * y) : y - error;
}

// A gap is an empty line: the curve begins anew after it.
void AppendData(const Chart& chart, const Curve& curve, std::string& script) {
  auto out = std::back_inserter(script);
  bool gap = true;
  for (std::size_t i = 0; i < Size(curve); ++i) {
    const double x = curve.x[i], y = curve.y[i];
    if (!IsDrawn(chart, x, y)) {
      if (!gap) fmt::format_to(out, "\n");
      gap = true;
      continue;
    }
    gap = false;
    const double given = i < curve.error.size() ? curve.error[i] : 0.0;
    const double error = std::isfinite(given) ? std::abs(given) : 0.0;
    fmt::format_to(out, "{:.9g} {:.9g} {:.9g} {:.9g}\n", x, y, LowEnd(chart, y, error), y + error);
  }
}

std::string Look(CurveLook look, std::size_t points) {
  const std::size_t every = 1 + points / kMostMarkers;
  switch (look) {
    case CurveLook::kBefore:
      return fmt::format("with linespoints lc rgb '#b45f06' lw 1.3 dt (6,4) pt 6 ps 0.6 pi {}",
                         every);
    case CurveLook::kAfter:
      return fmt::format("with linespoints lc rgb '#123f5f' lw 1.7 pt 7 ps 0.5 pi {}", every);
    case CurveLook::kBeforeDense:
      return "with lines lc rgb '#dd9a52' lw 1.1";
    case CurveLook::kAfterDense:
      return "with lines lc rgb '#123f5f' lw 1.4";
    case CurveLook::kErrorBars:
      return "with points lc rgb '#123f5f' lw 1.1 pt 6 ps 0.5";
    case CurveLook::kModel:
      return "with lines lc rgb '#b45f06' lw 1.8";
  }
  return {};
}

// Fixed margins, so that the frames of charts below one another stand in one line.
std::string Frame(const Chart& chart) {
  const int width = chart.wide ? kWideWidth : kNarrowWidth;
  return fmt::format(
      "set terminal svg size {},{} dynamic noenhanced font 'Helvetica,13'\n"
      "set lmargin at screen {:.4f}\nset rmargin at screen {:.4f}\n"
      "set bmargin at screen {:.4f}\nset tmargin at screen {:.4f}\n",
      width, kHeight, kLeft / width, 1.0 - kRight / width, kBottom / kHeight, 1.0 - kTop / kHeight);
}

// gnuplot takes a character of the legend for wider than it is; in characters.
double LegendCorrection(const Chart& chart) {
  std::size_t longest = chart.line_at_one.size();
  for (const Curve& curve : chart.curves) longest = std::max(longest, curve.name.size());
  return -0.15 * static_cast<double>(longest);
}

const char* Comma(const std::string& list) { return list.empty() ? "" : ", "; }

std::string Axes(const Chart& chart) {
  std::string script =
      "set encoding utf8\n"
      "set minussign\n" +
      Frame(chart) +
      "set border 3 lc rgb '#555555' lw 0.8\n"
      "set tics nomirror out scale 0.5 textcolor rgb '#333333'\n"
      "set xtics offset 0,0.4\n"
      "set ytics offset 0.4,0\n"
      "set grid lt 1 lc rgb '#e2e2e2' lw 0.7\n";
  // The label of y is put at a fixed place: a ylabel moves with the width of the numbers.
  const double width = chart.wide ? kWideWidth : kNarrowWidth;
  script += fmt::format(
      "set key at screen {:.4f}, screen {:.4f} left top horizontal maxrows 1 Left reverse "
      "samplen 2.4 width {:.1f} textcolor rgb '#222222'\n"
      "set xlabel {} offset 0,0.9\n"
      "set label 1 {} at screen {:.4f}, screen {:.4f} center rotate\n",
      kLeft / width, 1.0 - kLegendTop / kHeight, LegendCorrection(chart),
      Quoted(Shortened(chart.x_label)), Quoted(Shortened(chart.y_label)), kLabelX / width,
      0.5 + 0.5 * (kBottom - kTop) / kHeight);
  if (chart.log_axes) {
    script += "set logscale xy\nset format xy '%g'\nset mxtics 10\nset mytics 10\n";
  } else if (chart.zero_line) {
    script += "set xzeroaxis lt 1 lc rgb '#777777' lw 0.8\n";
  }
  // Round ticks look best when the axis ends at one of them.
  script +=
      chart.x_tick > 0.0 ? fmt::format("set xtics {:g}\n", chart.x_tick) : "set autoscale xfix\n";
  return script;
}

}  // namespace

std::size_t CountPoints(const Chart& chart) {
  std::size_t count = 0;
  for (const Curve& curve : chart.curves) count += CountPoints(chart, curve);
  return count;
}

std::string GnuplotScript(const Chart& chart) {
  std::string script = Axes(chart), plots;
  for (std::size_t i = 0; i < chart.curves.size(); ++i) {
    const Curve& curve = chart.curves[i];
    const std::size_t points = CountPoints(chart, curve);
    if (points == 0) continue;
    script += fmt::format("$curve{} << END\n", i);
    AppendData(chart, curve, script);
    script += "END\n";
    if (curve.look == CurveLook::kErrorBars) {
      plots += fmt::format("{}$curve{} using 1:3:(0):($4-$3) {} notitle", Comma(plots), i, kBars);
    }
    plots += fmt::format("{}$curve{} using 1:2 {} title {}", Comma(plots), i,
                         Look(curve.look, points), Quoted(curve.name));
  }
  if (!chart.line_at_one.empty()) {
    plots += ", 1 with lines lc rgb '#000000' lw 1.1 dt (2,3) title " + Quoted(chart.line_at_one);
  }
  return script + "plot " + plots + "\n";
}

}  // namespace gyrobench::presentation
