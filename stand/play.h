// The play operator: the follower of a loose link.
#pragma once

#include <algorithm>

namespace gyrobench::stand {

// Where the follower is when the leader has gone, without turning back, to `x`: it stays until the
// leader is half the play ahead, then follows. `before` is where it was.
constexpr double Follow(double before, double x, double half_width) {
  return std::clamp(before, x - half_width, x + half_width);
}

}  // namespace gyrobench::stand
