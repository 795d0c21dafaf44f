// Rotations written out, apart from those under test.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

#include "kinematics/stand_frame.h"

namespace gyrobench::kinematics {

inline Matrix3 Times(const Matrix3& a, const Matrix3& b) {
  Matrix3 out = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      for (std::size_t k = 0; k < 3; ++k) out[i][j] += a[i][k] * b[k][j];
    }
  }
  return out;
}

inline Matrix3 Transposed(const Matrix3& a) {
  Matrix3 out = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) out[i][j] = a[j][i];
  }
  return out;
}

// About x (0), y (1) or z (2).
inline Matrix3 About(int axis, double deg) {
  const double c = std::cos(deg * std::numbers::pi / 180),
               s = std::sin(deg * std::numbers::pi / 180);
  if (axis == 0) return {{{1, 0, 0}, {0, c, -s}, {0, s, c}}};
  if (axis == 1) return {{{c, 0, s}, {0, 1, 0}, {-s, 0, c}}};
  return {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}};
}

inline Matrix3 Product(const StandGeometry& g, const Vector3& angles_deg) {
  Matrix3 r = Times(About(2, angles_deg[0]), About(1, g.outer_middle_deg));
  r = Times(Times(r, About(0, angles_deg[1])), About(1, g.middle_inner_deg));
  r = Times(Times(r, About(2, angles_deg[2])), About(2, g.mount_deg[2]));
  return Times(Times(r, About(1, g.mount_deg[1])), About(0, g.mount_deg[0]));
}

// w_WS_S per unit of the stand's rates `rates_deg_s`, by central differences of orientations alone:
// R^T dR/dt = [w]x.
inline Vector3 NumericRate(const StandGeometry& g, const Vector3& angles_deg,
                           const Vector3& rates_deg_s) {
  constexpr double kStep_s = 1e-5;
  Vector3 later = angles_deg, earlier = angles_deg;
  for (std::size_t k = 0; k < 3; ++k) {
    later[k] += kStep_s * rates_deg_s[k];
    earlier[k] -= kStep_s * rates_deg_s[k];
  }
  const Matrix3 up = Product(g, later), down = Product(g, earlier);
  Matrix3 derivative = {};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      derivative[i][j] = (up[i][j] - down[i][j]) / (2 * kStep_s) * 180 / std::numbers::pi;
    }
  }
  const Matrix3 w = Times(Transposed(Product(g, angles_deg)), derivative);
  return {w[2][1], w[0][2], w[1][0]};
}

class Draws {
 public:
  explicit Draws(unsigned seed) : random_(seed) {}
  double Within(double limit) {
    return std::uniform_real_distribution<double>(-limit, limit)(random_);
  }
  Vector3 Angles(double limit) { return {Within(limit), Within(limit), Within(limit)}; }
  StandGeometry Geometry(double mount_deg, double square_deg) {
    return {Angles(mount_deg), Within(square_deg), Within(square_deg)};
  }

 private:
  std::mt19937 random_;
};

}  // namespace gyrobench::kinematics
