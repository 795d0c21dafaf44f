// Finds when one reference angle stands still, from its readings alone, and where a sensor without
// a reference was at rest.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/measurement.h"
#include "calibration/signal/columns.h"
#include "calibration/signal/line_sums.h"

namespace gyrobench::calibration {

// An axis rests when its readings of the last 0.5 s lie within a tolerance of one value; it moves
// again at the second reading in a row outside. One reading outside is an outlier. The tolerance
// follows the scatter and the step of the readings: 0.03 deg for a good encoder, 0.25 deg at most.
// Memory is bounded; readings faster than 4 ms apart are thinned.
class RestFinder {
 public:
  // Readings closer than this to the one before are not judged.
  static constexpr double kClosestReadings_s = 0.004;
  enum class Change { kNone, kRestBegan, kRestEnded, kOutlier };

  Change Add(double t_s, double angle_deg);
  // The reference was lost: nothing is known of what the axis did.
  void Reset();

  bool resting() const { return resting_; }
  // First reading at rest.
  double rest_begin_s() const { return rest_begin_s_; }
  // Last reading at rest so far.
  double last_at_rest_s() const { return last_at_rest_s_; }
  double tolerance_deg() const;
  bool within() const { return within_; }
  // The least difference of two readings in a row that is one; infinite where there was none.
  double step_deg() const { return step_deg_; }

 private:
  struct Reading {
    double t_s = 0.0;
    double angle_deg = 0.0;
  };
  static constexpr std::size_t kRing = 256;

  const Reading& back(std::size_t age) const { return ring_[(next_ + kRing - 1 - age) % kRing]; }
  void Learn(double t_s, double angle_deg);
  bool TryRest();

  std::array<Reading, kRing> ring_ = {};
  std::size_t next_ = 0, size_ = 0;
  bool resting_ = false, within_ = false;
  double rest_begin_s_ = 0.0, last_at_rest_s_ = 0.0, level_deg_ = 0.0;
  int outside_ = 0;
  // Scatter of the readings, from blocks of second differences, and the least step.
  double scatter_deg_ = 0.0, step_deg_ = std::numeric_limits<double>::infinity(), block_sum_ = 0.0;
  bool scatter_known_ = false;
  int block_count_ = 0;
};

// Slower is the creep of a table that holds, or of what the readings are relative to.
inline constexpr double kSlowestTurn_deg_s = 0.02;

// Angles over time [deg, s] that go on evenly for `lasts_s`: a line explains more of them than of a
// step between two rests, of which it explains three quarters at most.
bool IsSlowTurn(const LineSums& angles, double lasts_s);

// A rest that has begun: its readings so far.
struct OpenRest {
  double coarse_begin_s = 0.0;
  double last_at_rest_s = 0.0;
  Vector3 origin_deg = {};
  int axes = 1;                           // that are read
  double count_deg = 0.0;                 // step of a coarse encoder, or something smaller
  std::array<LineSums, 3> rotation = {};  // [deg] less `origin_deg`, over time since its begin [s]
  Vector3 change_square_deg2 = {};        // sum of the squares from one reading to the next
  Vector3 newest_deg = {};

  void Add(double t_s, const Vector3& rotation_deg);
  std::int64_t readings() const { return static_cast<std::int64_t>(rotation[0].n); }
  // It is no rest: the readings go on evenly, by more than their noise and faster than
  // kSlowestTurn_deg_s, as where a table turns so slowly that it stays within their tolerance for
  // half a second. A step between two long rests is told from that by what a line leaves of it; of a
  // hundred readings and fewer one may pass for a drift, and the rest for a motion.
  bool Drifts() const;
  // With the gyro's integral at its ends.
  Rest Between(const IntegralMark& begin, const IntegralMark& end) const;

 private:
  bool Drifts(std::size_t axis) const;
};

// Takes out of the rests, which are in order, what turns, and what the gyro leaves next to nothing
// of. Also those turn that follow each other without a pause, evenly and in one direction, as the
// counts of a coarse encoder do: in each alone there may be a count or none. In a measurement that
// goes on, what passed for rests may turn out to be such when the next one ends.
void PartSlowTurns(Columns* columns);

// Without a reference: the whole measurement is one rest, unless the accelerometer shows that the
// sensor was handled; then the stretches of 2 s and more in which neither it nor the gyro changes.
std::vector<Rest> RestsWithoutReference(const MeasurementInfo& info, const Columns& columns);

}  // namespace gyrobench::calibration
