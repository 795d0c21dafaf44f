// Cells of single axes that hold no number, in rows that were sampled all the same.
#pragma once

#include <array>
#include <cstddef>

#include "base/geometry.h"
#include "base/measurement.h"

namespace gyrobench::calibration {

// Up to two in a row are put on the line between the axis's samples before and after them, as where
// each axis is logged on rows of its own: with the value before in their place the axis would be
// late. A sample waits for that, and goes on in order. Longer stretches stay missing. Nothing is
// allocated.
class MissingCells {
 public:
  struct Sample {
    double t_s = 0.0;
    GyroSample as_it_came;
    Vector3 xi = {};  // filled
  };
  static constexpr std::size_t kMostInARow = 2;

  // `longest_s`: across a longer time nothing is filled.
  void Add(double t_s, const GyroSample& sample, const std::array<bool, 3>& present,
           double longest_s);
  // The oldest sample that need not wait; nullptr where there is none. It holds until the next Add.
  const Sample* Next();

 private:
  bool Waits(const Sample& sample) const;
  void Fill(std::size_t channel, std::size_t newest, double longest_s);

  std::array<Sample, kMostInARow + 2> samples_;
  std::size_t first_ = 0, count_ = 0;
  std::array<bool, 3> present_ = {};
  // Of each axis: its last number, and how many samples have come without one since.
  Vector3 last_s_ = {}, last_ = {};
  std::array<std::size_t, 3> missing_ = {kMostInARow + 1, kMostInARow + 1, kMostInARow + 1};
};

}  // namespace gyrobench::calibration
