// What is wrong with the data of a measurement: defects as they are met, what the samples say of
// how it is described, and what is refused.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::calibration {

struct Columns;
struct Recording;

class DefectLog {
 public:
  // One row per kind and `where`; the first time stays.
  void Add(std::string_view kind, std::string_view where, double t_s, std::int64_t count = 1);
  const std::vector<Defect>& defects() const { return defects_; }

 private:
  std::vector<Defect> defects_;
};

// Sentences without the measurement's name: counts of an unsigned converter whose zero nobody gave,
// an angle of the reference that jumps by whole turns, a temperature that no sensor has, an
// accelerometer in another unit than its columns say.
std::vector<std::string> IntakeRemarks(const Recording& recording);

// Counts of the gyro are those of an unsigned converter whose zero nobody gave.
bool HasUnsignedGyro(const Recording& recording);

// Throws DataError where there is no sample of the gyro, with what was wrong first. `expected`: of
// the measurement.
void RefuseNoSamples(const std::string& source, std::int64_t samples,
                     const std::vector<Defect>& defects, const char* expected);

// Throws DataError where samples come so far apart that no angle can be summed up from them, as
// where t_s is in milliseconds.
void RefuseSamplesFarApart(const Recording& recording);

// What calibrates a sensor without any reference, and what it still takes where that is not there.
std::string WithoutReference(const MeasurementInfo& info);

// Whether a quaternion of another convention than the table's (w, x, y, z; rotates vectors of the
// sensor's frame into the world's) makes gyro and reference agree where the one given does not: the
// inverse, the scalar part last, first where it was declared last, or both. They agree where each
// channel that its axis turns follows that rate,
//   dz/dt = b + g w,   g > 0 and about the nominal sensitivity, or alike in all where none is known
// and what all leave of their variance is little. A sentence that names the convention and what to
// do; empty where the one given agrees, or none does, or there is no such reference.
std::string OtherConvention(const MeasurementInfo& info, const Columns& columns);

// Zero-rate offset that no part goes beyond (see TurnsWithoutReference).
inline constexpr double kLargestOffset_deg_s = 80.0;

// Of a measurement without a reference, in means of 0.5 s over what is taken for rest:
//   - the rate leaves the one at which the channel stands most by more than 5 deg/s and within 5 s,
//     for 1 s in all or more, as a turn does: steps of the offset of such parts are below 0.5 deg/s
//     (effect bias.step), and what temperature does is slower; or
//   - it stands at more than 80 deg/s: the zero-rate offset of a part is within 40 deg/s at
//     25 degC, and moves by another 40 deg/s over its range of temperature (ITG-3200 data sheet,
//     section 3.1, the largest of consumer parts). Not of counts whose sensitivity or zero nobody
//     gave.
// A sentence: what was found, when, what it means and what to do; empty where there is nothing.
std::string TurnsWithoutReference(const Recording& recording);

}  // namespace gyrobench::calibration
