// Draws charts with gnuplot and puts them into a page.
#pragma once

#include <chrono>
#include <string>

#include "presentation/chart.h"
#include "presentation/markup.h"

namespace gyrobench::presentation {

class Charter {
 public:
  // `gnuplot`: the program, looked for in PATH. One that hangs is ended after `limit`.
  explicit Charter(std::string gnuplot = "gnuplot",
                   std::chrono::milliseconds limit = std::chrono::seconds(20));

  // The chart as a numbered figure, or the reason why there is none and what to do about it.
  struct Drawn {
    Markup figure;
    std::string why_not;
  };
  Drawn Draw(const Chart& chart);

 private:
  std::string gnuplot_;
  std::chrono::milliseconds limit_;
  int figures_ = 0;
  std::string trouble_;  // that holds for all charts to come
};

// One SVG of gnuplot made fit for a page: no XML head, no titles of its own, no fonts, ids that
// begin with `prefix`, `label` for those who cannot see it. Empty where `svg` is no whole SVG.
Markup InlineSvg(const std::string& svg, const std::string& prefix, const std::string& label);

}  // namespace gyrobench::presentation
