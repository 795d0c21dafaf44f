// The gyro's latest samples at full rate, and the integral of its output.
#pragma once

#include <cstdint>
#include <vector>

#include "calibration/signal/columns.h"

namespace gyrobench::calibration {

// The integral is that of a monotone cubic spline through the samples: the trapezoid rule cuts the
// corners of a rate that bends, by interval^2 / 12 times the change of the angular acceleration.
// Nothing is integrated across a gap. Bounded; nothing is allocated after construction.
class GyroRing {
 public:
  struct Point {
    double t_s = 0.0;
    Vector3 z = {};   // since the first sample
    Vector3 xi = {};  // output
    BetweenSamples between = {};
    bool gap = false;    // between the sample before and this one
    Vector3 chord = {};  // slope of the straight line from the sample before, where it is known
    Vector3 slope = {};  // of the spline
    bool has_chord = false;
  };
  static constexpr std::size_t kSize = 4096;  // a power of two

  GyroRing();

  std::int64_t count() const { return count_; }
  // Of samples count() - kSize .. count() - 1.
  const Point& at(std::int64_t index) const {
    return points_[static_cast<std::size_t>(index) & (kSize - 1)];
  }
  std::int64_t oldest() const;
  // Index of the first sample at or after that time; count() where there is none yet.
  std::int64_t FirstNotBefore(double t_s) const;

  // Times must grow.
  void Push(double t_s, const Vector3& xi, bool gap);
  // Another value in place of the newest sample's.
  void Replace(std::size_t channel, double xi);
  // Up to here nothing changes any more: the newest sample may yet be replaced, and the spline
  // before a sample bends with the one after it. -infinity with fewer than three samples.
  double settled_time_s() const;
  // The integral at `t_s`. False when that time is not, or no longer, remembered.
  bool IntegralAt(double t_s, IntegralMark* mark) const;
  // Up to the last sample not after `t_s`; nothing where that is not remembered.
  BetweenSamples BetweenUpTo(double t_s) const;
  // 0 where the samples follow each other so fast that it is nothing beside any noise, and where
  // `t_s` is not remembered or lies in a gap.
  AsMeans AsMeansAt(double t_s) const;
  // AsMeansAt half an interval of the samples after `t_s`.
  AsMeans AsMeansHalfAfter(double t_s) const;
  // Whether no later sample changes what these two say of `t_s`.
  bool MeansSettledAt(double t_s) const;
  // Of the samples not after `t_s`. Not known where that time is not, or no longer, remembered, or
  // lies in a gap.
  SampleSum SumUpTo(double t_s) const;

 private:
  Point& point(std::int64_t index) {
    return points_[static_cast<std::size_t>(index) & (kSize - 1)];
  }
  double Jump(std::int64_t i, std::size_t c) const;
  void AddBetween(std::int64_t next);
  double AsMeansAtSample(std::int64_t i, std::size_t c) const;
  double ShorterIntervalAt(std::int64_t i) const;
  double ShortestBeside(std::int64_t next) const;
  double SlowIntervalBefore(std::int64_t next) const;
  void SetChord(std::int64_t to);
  void SetSlope(std::int64_t i);
  bool HasChordFrom(std::int64_t from) const;
  double SplineIntegral(std::int64_t next, std::size_t c, double x) const;

  std::vector<Point> points_;
  std::int64_t count_ = 0;
};

}  // namespace gyrobench::calibration
