// Turns that are even for longer than one reading after the other can tell: there a line through
// many readings says where the table is, without the noise of each, and without the gyro's.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace gyrobench::calibration {

// One angle node by node, which may be off by any constant.
struct AngleSeries {
  std::span<const double> t_s;
  std::span<const double> read_deg;  // by the reference; NaN: it is not known
  std::span<const double> felt_deg;  // by the gyro, which may drift evenly
  double error_deg = 0.0;            // of a node of `read_deg`: noise, or rounding to counts
  double walk_deg_sqrt_s = 0.0;      // of `felt_deg`: its angle random walk
};

// A line goes through so many nodes before a time and after it, at most.
inline constexpr std::size_t kLongestReach = 64;

// Whether the turns about one axis from node `begin` to `end`, both inclusive, are no small part of
// those about any: what is left of the readings' noise in a small part is nothing beside the rest.
// `read_deg`: about each axis, node by node.
bool HasPartIn(const std::array<std::vector<double>, 3>& read_deg, std::size_t axis,
               std::size_t begin, std::size_t end);

struct EvenTurn {
  // At the time that was asked for.
  double angle_deg = 0.0, rate_deg_s = 0.0, acceleration_deg_s2 = 0.0;
};

// By the line through the nodes about `t_s`, which lies between nodes `before` and `before` + 1 or
// on the first, or a cubic: of 16 to 129 nodes within [begin, end), as many as go on evenly: what
// it leaves of the readings is no more than their errors, and of the gyro no more than its random
// walk. Nothing where none do, or where the readings next to each other tell the rate well enough:
// what is left of their noise, which may be alike from one to the next as rounding to counts is, is
// a thousandth of the rate or less.
std::optional<EvenTurn> FindEvenTurn(const AngleSeries& series, std::size_t before, double t_s,
                                     std::size_t begin, std::size_t end);

}  // namespace gyrobench::calibration
