// By how much an encoder's value is older than the gyro's, from moves that both saw.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "commission/measurements.h"
#include "commission/probe.h"

namespace gyrobench::commission {

// Of one move after the other. An encoder whose counts a, times t, go with the angle theta that the
// gyro's rates w add up to has, to first order in its delay tau,
//   a = c + k (theta(t) - tau w(t)),
// whose scale k, of either order of its words, need not be known.
class DelaySeen {
 public:
  // A move begins.
  void Begin(std::size_t encoders);
  void Add(std::size_t encoder, const Devices::Angle& angle);
  // It is over; `rates`: all of the gyro's in it, `rest_deg_s`: its offset.
  void End(std::span<const Devices::Rate> rates, const Vector3& rest_deg_s);
  // Of each encoder, over all moves that it followed.
  std::vector<std::optional<Measurements::Delay>> Found() const;

 private:
  struct Sum {
    double weight = 0.0, weighted_s = 0.0;
    double rounding_s =
        0.0;  // half a count at the speed of a move, which repeats from move to move
  };
  std::vector<std::vector<Devices::Angle>> angles_;
  std::vector<Sum> sums_;
};

}  // namespace gyrobench::commission
