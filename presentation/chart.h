// One chart as data, and as the script that lets gnuplot draw it.
#pragma once

#include <string>
#include <vector>

namespace gyrobench::presentation {

// How a curve looks; each is told from the others without colour too.
enum class CurveLook {
  kBefore,       // dashed line, open circles
  kAfter,        // solid dark line, filled circles
  kBeforeDense,  // light line: long series against time or frequency
  kAfterDense,   // thin dark line
  kErrorBars,    // open circles with error bars
  kModel,        // line without markers
};

struct Curve {
  std::string name;  // of the legend
  CurveLook look = CurveLook::kBefore;
  std::vector<double> x, y;   // a value that is not finite is a gap
  std::vector<double> error;  // kErrorBars: standard error of y
};

struct Chart {
  std::string title;  // said below the chart and to those who cannot see it
  std::string x_label, y_label;
  bool wide = false;  // over the whole width of the page
  bool log_axes = false;
  bool zero_line = true;
  double x_tick = 0.0;      // distance of the ticks; 0: as fits
  std::string line_at_one;  // log axes: the name of the line y = 1; none where empty
  std::vector<Curve> curves;
  std::string why_empty;  // said in its place where no curve has a point
};

// Points that can be drawn: finite and, on log axes, positive.
std::size_t CountPoints(const Chart& chart);

// A script for gnuplot 5.4 that writes one SVG to its standard output. All text of the chart is
// quoted so that gnuplot evaluates nothing in it.
std::string GnuplotScript(const Chart& chart);

}  // namespace gyrobench::presentation
