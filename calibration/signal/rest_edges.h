// When the sensor came to rest and when motion began, to a sample, by the gyro itself.
#pragma once

#include <array>

#include "calibration/signal/gyro_ring.h"

namespace gyrobench::calibration {

class RestEdges {
 public:
  // `digit`: the least noise that a sample can have, output units.
  RestEdges(const GyroRing& ring, const std::array<bool, 3>& present, double digit)
      : ring_(ring), present_(present), digit_(digit) {}

  // When the sensor came to rest, searched around `coarse_s`, the first reading of the reference at
  // rest: the earliest time after which no channel shows rotation. Needs samples up to coarse_s +
  // 0.45 s.
  double Begin(double coarse_s) const;
  // When motion began, searched between `coarse_s` - 0.15 s (the reference's last reading at rest)
  // and `moving_s` + 0.1 s (it surely moves): the latest time before which no channel shows
  // rotation.
  double End(double coarse_s, double moving_s) const;

 private:
  struct Quiet {
    Vector3 mean = {};
    Vector3 threshold = {};
    int samples = 0;
  };
  Quiet QuietBetween(double begin_s, double end_s) const;
  double Deviation(const Quiet& quiet, std::int64_t index) const;

  const GyroRing& ring_;
  const std::array<bool, 3>& present_;
  double digit_;
};

}  // namespace gyrobench::calibration
