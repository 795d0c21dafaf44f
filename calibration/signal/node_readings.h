// All readings of the reference that belong to one node, and what they say together.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "calibration/signal/columns.h"
#include "calibration/signal/gyro_stream.h"

namespace gyrobench::calibration {

// A reading brings its error into the rotation once; the mean over the readings of a node brings
// that of one reading over their number. So that nothing is carried from one time to another, the
// output's integral is averaged over the very same times:
//   mean_r(rotation(t_r)) - mean_r(z(t_r)) / s0 = mean_r(error_r) + what an effect does there
// Readings within a few milliseconds of each other count as one at their mean time, with the weight
// of all. Bounded; nothing is allocated but what `within` grows by.
class NodeReadings {
 public:
  struct Reading {
    double t_s = 0.0;
    Vector3 rotation_deg = {}, earth_deg = {}, table_deg = {}, world_x = {}, world_z = {};
  };

  bool empty() const { return size_ == 0; }
  double newest_s() const { return newest_.t_s; }
  // Times must grow.
  void Add(const Reading& reading);
  // Says the newest reading anew: another axis was read at the same time.
  void Replace(const Reading& newest) { newest_ = newest; }
  // A reading of one axis of the stand, whatever the others were when they were last read.
  void AddOwn(std::size_t axis, double table_deg) {
    own_readings_[axis] += 1.0;
    own_sum_deg_[axis] += table_deg;
  }
  void Clear() { *this = {}; }
  // An axis turned since then and had not been read: of readings that go so far none counts.
  void ForgetFrom(double since_s) {
    if (!empty() && newest_.t_s > since_s) Clear();
  }

  // What the reference says, and the times.
  ReadingsMean Mean() const;
  // Fills the means of the output's integral; `within`: what the readings say beyond the means goes
  // to its end. False where there is no reading, or the gyro's samples do not reach; so does
  // AverageNear.
  bool AverageOutput(const GyroStream& gyro, ReadingsMean* mean,
                     std::vector<ReadingWithin>* within) const;
  // Means of the output's integral at kNear_s from the readings, less that at the readings.
  bool AverageNear(const GyroStream& gyro, Near* near) const;

 private:
  static constexpr std::size_t kMost = 24;
  static constexpr double kTogether_s = 0.0055;
  struct Group {
    double t_s = 0.0;  // mean
    double weight = 0.0;
    Vector3 rotation_deg = {};  // sum over all but the newest
  };
  void Count();
  void AppendWithin(const std::array<IntegralMark, kMost>& at, const ReadingsMean& mean,
                    std::vector<ReadingWithin>* within) const;

  Reading sum_;  // of all but the newest
  Reading newest_;
  std::array<Group, kMost> groups_ = {};  // the newest among them
  std::size_t size_ = 0;
  double readings_ = 0.0;
  Vector3 own_readings_ = {}, own_sum_deg_ = {};
};

}  // namespace gyrobench::calibration
