// What a run measured, as a stream: the door between those who have measurements (records, tables,
// the running daemon) and those who analyse them. Plain values, no I/O.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/geometry.h"

namespace gyrobench {

inline constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

// Sensor axes, in the order of all arrays of three.
enum class SensorAxis { kX = 0, kY = 1, kZ = 2 };
// Stand axes, in the order of all arrays of three (geometry: docs/measurement-table.md).
enum class StandAxis { kOuter = 0, kMiddle = 1, kInner = 2 };

// What the reference measures.
enum class ReferenceKind {
  kNone,         // no reference: the sensor is taken to be at rest in the room
  kStandAngles,  // angles of the three axes of the stand, each at its own time
  kSensorAngle,  // one angle about a nominal axis of the sensor
  kOrientation,  // unit quaternion, sensor frame into world frame (z up)
};

// Unit of the gyro's output xi. The first is a raw count, the others a sensor that scales by
// itself.
enum class RateUnit { kLsb, kDegPerSecond, kRadPerSecond };

// How well the reference angle itself is known, from its certificate; decision 12 of the design:
// what is declared is carried as uncertainty, and only what goes beyond it is an effect.
struct ReferenceUncertainty {
  // Relative standard uncertainty of a turned angle. Empty: nothing is said.
  std::optional<double> scale;
  // Largest amplitude of an error that repeats once a turn of the reference (eccentricity) [deg].
  std::optional<double> eccentricity_deg;
  // Largest angle between the axis of the reference and the axis that turns [deg].
  std::optional<double> alignment_deg;

  bool said() const { return scale || eccentricity_deg || alignment_deg; }
  bool operator==(const ReferenceUncertainty&) const = default;
};

// What is true of the whole measurement.
struct MeasurementInfo {
  std::string source;  // file or run id, for messages
  RateUnit gyro_unit = RateUnit::kLsb;
  std::array<bool, 3> gyro_present = {false, false, false};
  std::array<bool, 3> accel_present = {false, false, false};
  bool temperature_present = false;
  // Nominal sensitivity, output units per deg/s. From the record, the table's comment or the unit.
  std::optional<double> gyro_units_per_deg_s;
  // Count of the source's converter that stands for zero; taken off where samples enter, so that
  // GyroSample has none of it. Empty: a signed converter, or one that nobody described.
  std::optional<double> gyro_lsb_zero, accel_lsb_zero;
  ReferenceKind reference = ReferenceKind::kNone;
  ReferenceUncertainty reference_uncertainty;
  std::array<bool, 3> stand_axis_present = {false, false, false};  // for kStandAngles
  SensorAxis reference_axis = SensorAxis::kZ;                      // for kSensorAngle
  StandGeometry geometry;                                          // of the stand, for kStandAngles
  std::optional<double> site_latitude_deg;
  double site_heading_deg = 0.0;     // heading of world x from north
  std::optional<double> gear_ratio;  // shaft turns per table turn
  std::optional<double>
      stop_accuracy_deg;  // half-width of the table's stop, shaft accuracy / ratio
  // What is declared of the sensor and the reference (by device map or table): a value is that of
  // so long before its stamp. The analysis takes it off; only what goes beyond it is an effect.
  double gyro_delay_s = 0.0;
  double reference_delay_s = 0.0;
  std::string sensor;    // serial number
  std::string power_on;  // measurements with the same value share one power-on
  // Of a run: host time of the power-on from which t_s counts [us since the epoch], its begin or
  // before. Empty: not known, and t_s counts from the begin of the run.
  std::optional<std::int64_t> power_on_utime;
  std::map<std::string, std::string>
      notes;  // keys of the source with no meaning here, kept and shown
  // Of a table: lines on which keys of its head stand, and the first line of data (0: no table).
  std::map<std::string, std::int64_t> key_lines;
  std::int64_t first_row_line = 0;
  std::vector<std::string> covariates;  // names of further columns
};

// One sample of the sensor. Missing values are NaN.
struct GyroSample {
  // Since the power-on where the measurement says when that was, else since its start; host clock.
  double t_s = 0.0;
  // Output xi, frame S, in MeasurementInfo::gyro_unit.
  std::array<double, 3> xi = {kMissing, kMissing, kMissing};
  // Specific force, frame S, in g.
  std::array<double, 3> accel_g = {kMissing, kMissing, kMissing};
  double temperature_degC = kMissing;
};

// One reading of an angle of the reference, right-handed, unwrapped [deg].
struct AngleSample {
  double t_s = 0.0;
  int axis = 0;  // StandAxis for kStandAngles, SensorAxis for kSensorAngle
  double angle_deg = kMissing;
};

// One reading of an orientation reference: unit quaternion, rotates sensor-frame vectors into W.
struct OrientationSample {
  double t_s = 0.0;
  std::array<double, 4> q_wxyz = {kMissing, kMissing, kMissing, kMissing};
};

// One pairing of the sensor unit's clock with the host's.
struct TickPair {
  double tick_s = 0.0;  // unwrapped tick over the unit's nominal tick rate
  double host_s = 0.0;  // host time of that tick
};

// A named stretch of a run has ended (rest, turn, soak, ...).
struct SegmentMark {
  double begin_s = 0.0;
  double end_s = 0.0;
  std::string kind;
  std::string name;
};

// Kind of the defect that the sensor's unit began anew within the measurement.
inline constexpr const char* kUnitRestarted = "unit_restarted";

// Something wrong with the data, counted and placed; never explained by an effect.
struct Defect {
  std::string kind;  // repeated_time, gap, not_a_number, samples_lost, damaged_log, ...
  std::int64_t count = 0;
  double first_t_s = kMissing;
  std::string where;  // line, byte or channel of the first one
};

// Receives a measurement in the order of time (each kind of sample is in order; kinds may
// interleave within one poll of a device).
class MeasurementSink {
 public:
  virtual ~MeasurementSink() = default;
  // Once, before all others.
  virtual void OnInfo(const MeasurementInfo& info) = 0;
  virtual void OnGyro(const GyroSample& sample) = 0;
  // Further numeric columns at the time of a sample, in the order of MeasurementInfo::covariates;
  // NaN where a value is missing. Comes before the gyro sample of the same time.
  virtual void OnCovariates(double /*t_s*/, std::span<const double> /*values*/) {}
  virtual void OnAngle(const AngleSample& sample) = 0;
  virtual void OnOrientation(const OrientationSample& sample) = 0;
  virtual void OnTickPair(const TickPair& pair) = 0;
  virtual void OnSegment(const SegmentMark& mark) = 0;
  virtual void OnDefect(const Defect& defect) = 0;
};

}  // namespace gyrobench
