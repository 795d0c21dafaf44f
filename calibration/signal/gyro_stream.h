// The gyro's samples as they come: time stamps mended, defects noticed, output integrated.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/columns.h"
#include "calibration/signal/fingerprints.h"
#include "calibration/signal/freeze.h"
#include "calibration/signal/gyro_ring.h"
#include "calibration/signal/intake.h"
#include "calibration/signal/missing_cells.h"
#include "calibration/signal/output_digits.h"
#include "calibration/signal/rest_edges.h"
#include "calibration/signal/saturation.h"
#include "calibration/signal/wrapped_counts.h"

namespace gyrobench::calibration {

// Integrates xi (gyro_ring.h) and remembers the last few seconds at full rate, so that the integral
// at the time of a reference reading, and the instant at which motion begins (rest_edges.h), can be
// found. Memory is bounded; nothing is allocated per sample.
//
// Mended: a repeated time stamp (the sample is put between its neighbours). Bridged: up to two
// samples that are not a number (missing_cells.h), and single wild samples. Marked as not to be
// used: gaps, longer stretches of NaN, a frozen sensor (freeze.h), saturation (saturation.h).
//
// A wild sample lies off the line between its neighbours by over 8 times the largest such bend of
// the 32 samples before it (8 in the first of a recording), and by more than 5000 deg/s2 would
// bring about, while both neighbours and the sample before them agree within a quarter of that, or
// lie on a line within it and the other channels go on as usual. No table, motor or hand does that:
// on measured data, reversals of a stepper at 250 deg/s among them, bends grow to 1.7 times the
// largest before, knocks of a hand to 11 times at 3600 deg/s2. So does one by 40 times and 300
// deg/s2 (100 where the other channels go on as usual), or by 12 times where its neighbours and the
// sample before agree within twice the largest bend, as at rest and at a steady rate; but not
// within 5 s of another, as a table that steps would make them, unless a hundredth of it would show
// in another channel that goes on as usual.
class GyroStream {
 public:
  GyroStream();
  void Start(const MeasurementInfo& info);
  void Add(const GyroSample& sample);

  std::int64_t samples() const { return samples_; }
  const Fingerprints& fingerprints() const { return fingerprints_; }
  bool started() const { return ring_.count() > 0; }
  double first_time_s() const { return first_time_s_; }
  double last_time_s() const { return last_time_s_; }
  // Up to here nothing changes any more.
  double settled_time_s() const { return ring_.settled_time_s(); }
  // Median interval of the samples. NaN with fewer than two.
  double median_interval_s() const;
  const std::array<std::int64_t, 3>& valid_samples() const { return valid_samples_; }
  // Of all samples so far. What was said of a saturation or a freeze may be taken back by samples
  // that come later.
  std::vector<Defect> defects() const;
  std::vector<BadStretch> bad() const;
  // So far: the output is in counts of an unsigned converter (base/unsigned_counts.h) whose zero
  // nobody gave, and which is in the integral.
  bool unsigned_counts() const { return saturation_.unsigned_counts(); }
  // Of what came of a channel so far.
  OutputRounding rounding(std::size_t channel) const { return digits_[channel].Rounding(); }
  // The latest samples, mended.
  const GyroRing& ring() const { return ring_; }

  // The integral at `t_s`. False when that time is not, or no longer, remembered.
  bool IntegralAt(double t_s, IntegralMark* mark) const { return ring_.IntegralAt(t_s, mark); }
  // See GyroRing.
  SampleSum SumUpTo(double t_s) const { return ring_.SumUpTo(t_s); }
  // See RestEdges.
  double RestBegin(double coarse_s) const;
  double RestEnd(double coarse_s, double moving_s) const;

 private:
  static constexpr std::size_t kHeld = 8;
  static constexpr std::size_t kBins = 512;
  static constexpr std::size_t kBends = 32;

  // The newest sample is back(1).
  const GyroRing::Point& back(std::int64_t n) const { return ring_.at(ring_.count() - n); }
  RestEdges Edges() const;
  void PlaceHeld(double t_s);
  void Enter(double t_s, const GyroSample& sample);
  void Accept(const MissingCells::Sample& sample);
  void MendNewest(double next_t_s, const Vector3& next);
  bool IsWild(std::size_t c, const Vector3& offs, double off_deg_s2, double next_t_s, double next);
  double LargestBend(std::size_t c) const;
  bool OthersGoOn(std::size_t c, const Vector3& offs) const;
  bool OthersWouldFeel(std::size_t c, const Vector3& offs) const;
  void Bridge(std::size_t c, double line);
  void CountInterval(double interval_s);
  Vector3 Take(const MissingCells::Sample& sample);
  void WatchSettled();
  std::vector<SaturationWatch::Finding> Saturated() const;
  void MarkBad(double begin_s, double end_s, std::array<bool, 3> channels);

  MeasurementInfo info_;
  double to_output_ = 1.0;  // rad/s to deg/s where needed
  DefectLog defects_;
  std::vector<BadStretch> bad_;
  GyroRing ring_;
  std::int64_t samples_ = 0;
  Fingerprints fingerprints_;
  double first_time_s_ = 0.0, last_time_s_ = 0.0;
  double last_raw_time_s_ = 0.0;
  double gap_limit_s_ = 0.25;

  MissingCells missing_cells_;
  std::array<GyroSample, kHeld> held_;
  std::size_t held_count_ = 0;

  std::array<std::int64_t, 3> valid_samples_ = {};
  std::array<double, 3> last_valid_t_s_ = {};
  std::array<int, 3> missing_ = {};

  SaturationWatch saturation_;
  FreezeWatch freeze_;
  WrappedCounts wrapped_;
  std::array<OutputDigits, 3> digits_;
  std::optional<double> watched_t_s_;  // of the newest sample
  Vector3 watched_ = {};

  // How far the latest samples lay off the line between their neighbours.
  std::array<std::array<double, kBends>, 3> bend_ = {};
  std::int64_t bends_ = 0;
  Vector3 last_small_wild_s_ = {kMissing, kMissing, kMissing};
  double per_deg_s_ = 1.0;  // output units
  double digit_ = 0.0;      // what the last digit of a sample can make of a bend

  // Histogram of the logarithm of the intervals, and their sums, for the median.
  std::size_t bin_ = 0;
  double bin_low_s_ = 0.0, bin_high_s_ = 0.0;  // of the last interval's bin
  std::array<std::int64_t, kBins> interval_count_ = {};
  std::array<double, kBins> interval_sum_ = {};
};

}  // namespace gyrobench::calibration
