// How far one quantity follows another on a line y = b + g x.
#pragma once

namespace gyrobench::calibration {

// Sums over pairs; without pairs, or where x does not vary, what is asked of them is NaN. They are
// not centred: for telling what follows what, not for estimates.
struct LineSums {
  double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, yy = 0.0;

  void Add(double at, double value) {
    n += 1.0;
    x += at;
    y += value;
    xx += at * at;
    xy += at * value;
    yy += value * value;
  }
  // n times the variances and the covariance.
  double SquareX() const { return xx - x * x / n; }
  double SquareY() const { return yy - y * y / n; }
  double Product() const { return xy - x * y / n; }

  // g
  double Slope() const { return Product() / SquareX(); }
  // b
  double Offset() const { return (y - Slope() * x) / n; }
  // Share of the variance of y that the line explains.
  double Explained() const { return Product() * Product() / (SquareX() * SquareY()); }
  // n times the variance of y that it leaves.
  double LeftOfY() const { return SquareY() - Slope() * Product(); }
};

}  // namespace gyrobench::calibration
