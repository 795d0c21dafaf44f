#include "calibration/signal/stamp_line.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobench::calibration {

void StampLine::Add(double place, double s, double memory) {
  if (weight >= memory) {
    const double keep = memory / (memory + 1.0);
    weight *= keep;
    square *= keep;
    product *= keep;
    stamps_square *= keep;
  }
  weight += 1.0;
  const double from_place = place - mean_place, from_s = s - place * step_s - mean_s;
  mean_place += from_place / weight;
  mean_s += from_s / weight;
  square += from_place * (place - mean_place);
  product += from_place * (s - place * step_s - mean_s);
  stamps_square += from_s * (s - place * step_s - mean_s);
}

void StampLine::MakeStepsItsOwn() {
  const double more_s = product / square;
  stamps_square -= product * more_s;
  mean_s -= more_s * mean_place;
  step_s += more_s;
  product = 0.0;
}

double JustAfter(double t_s) {
  constexpr double kApart_s = 1e-9;
  return std::max(t_s + kApart_s, std::nextafter(t_s, std::numeric_limits<double>::infinity()));
}

}  // namespace gyrobench::calibration
