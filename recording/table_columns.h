// What the head of a measurement table says: comments and column names (docs/measurement-table.md).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/measurement.h"

namespace gyrobench::recording {

inline constexpr std::size_t kMaxTableColumns = 4096;
inline constexpr double kStandardGravity_m_s2 = 9.80665;

enum class ColumnKind {
  kTime,         // t_s
  kGyro,         // index: SensorAxis
  kAccel,        // index: SensorAxis; times scale: g
  kTemperature,  // degC
  kStandAngle,   // index: StandAxis; degrees
  kSensorAngle,  // index: SensorAxis; degrees
  kQuaternion,   // index: 0..3 = w, x, y, z
  kUnitTick,     // unit_tick_s: the sensor unit's own clock at t_s
  kCovariate,    // under its own name
};

struct TableColumn {
  std::string name;
  ColumnKind kind = ColumnKind::kCovariate;
  int index = 0;
  double zero = 0.0;   // what stands for zero in the column
  double scale = 1.0;  // from the column's unit to MeasurementSink's

  // A field's value in the unit of MeasurementSink. NaN stays NaN.
  double Measured(double value) const { return (value - zero) * scale; }
  // Raw counts of a converter, as its column's name says.
  bool IsInCounts() const { return name.ends_with("_lsb"); }
};

// Comments and header line, as they were met.
class TableHead {
 public:
  explicit TableHead(std::string file) : file_(std::move(file)) {}

  // A line that begins with '#'. Throws DataError for a known key whose value cannot be used.
  void Comment(std::string_view line, std::int64_t line_number);
  // The header line. Throws DataError that names the column and what was expected.
  void Header(std::string_view line, std::int64_t line_number);

  const std::vector<TableColumn>& columns() const { return columns_; }
  std::size_t time_column() const { return time_column_; }
  const MeasurementInfo& info() const { return info_; }
  // Of a table written from a record: `# segment = ...`, `# defect = ...`.
  const std::vector<SegmentMark>& segments() const { return segments_; }
  const std::vector<Defect>& defects() const { return defects_; }

 private:
  void Key(const std::string& key, const std::string& value, std::int64_t line_number);
  [[noreturn]] void Fail(std::int64_t line_number, const std::string& what) const;
  double Number(const std::string& key, const std::string& value, double min, double max,
                std::int64_t line_number) const;
  void Segment(const std::string& value, std::int64_t line_number);
  void RecordedDefect(const std::string& value, std::int64_t line_number);
  void CheckColumns(std::int64_t line_number);
  void CheckReferenceUnits(std::int64_t line_number) const;
  void CheckNearNames(std::int64_t line_number) const;
  void CheckUnits(ColumnKind kind, std::int64_t line_number) const;
  void CheckReference(std::int64_t line_number);
  void FillInfo(std::int64_t line_number);
  void ScaleAccel(TableColumn& column) const;
  void FillGyroUnit();
  std::string Names(ColumnKind kind) const;

  std::string file_;
  MeasurementInfo info_;
  std::vector<TableColumn> columns_;
  std::size_t time_column_ = 0;
  double gyro_lsb_per_deg_s_ = kMissing;
  double accel_lsb_per_g_ = kMissing;
  std::vector<SegmentMark> segments_;
  std::vector<Defect> defects_;
};

}  // namespace gyrobench::recording
