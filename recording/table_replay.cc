#include <fmt/format.h>

#include <cmath>

#include "recording/measurement_table.h"
#include "recording/replay.h"

namespace gyrobench::recording {

namespace {

// Where a column's value goes.
struct Target {
  std::size_t column = 0;
  std::size_t index = 0;
  double scale = 1.0;
};

// Rows of a table as events of a measurement.
class RowEvents {
 public:
  RowEvents(const TableReader& reader, MeasurementSink& sink)
      : sink_(sink), time_(reader.head().time_column()), segments_(reader.head().segments()) {
    const std::vector<TableColumn>& columns = reader.columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      Add({i, static_cast<std::size_t>(columns[i].index), columns[i].scale}, columns[i].kind);
    }
    covariates_.resize(covariate_columns_.size());
    no_gyro_ = counter_.Add("no_gyro");
    bad_quaternion_ = counter_.Add("bad_quaternion");
  }

  void Emit(const double* row) {
    const double t_s = row[time_];
    EmitSegmentsBefore(t_s);
    EmitGyro(row, t_s);
    for (const Target& angle : angles_) {
      if (!std::isnan(row[angle.column])) {
        sink_.OnAngle({t_s, static_cast<int>(angle.index), row[angle.column]});
      }
    }
    if (!quaternion_.empty()) EmitOrientation(row, t_s);
    for (const Target& tick : ticks_) {
      if (!std::isnan(row[tick.column])) sink_.OnTickPair({row[tick.column], t_s});
    }
  }
  void End() {
    EmitSegmentsBefore(std::numeric_limits<double>::infinity());
    for (const Defect& defect : counter_.Found()) sink_.OnDefect(defect);
  }

 private:
  void Add(const Target& target, ColumnKind kind) {
    switch (kind) {
      case ColumnKind::kGyro:
        gyro_.push_back(target);
        break;
      case ColumnKind::kAccel:
        accel_.push_back(target);
        break;
      case ColumnKind::kTemperature:
        temperature_.push_back(target);
        break;
      case ColumnKind::kStandAngle:
      case ColumnKind::kSensorAngle:
        angles_.push_back(target);
        break;
      case ColumnKind::kQuaternion:
        quaternion_.push_back(target);
        break;
      case ColumnKind::kUnitTick:
        ticks_.push_back(target);
        break;
      case ColumnKind::kCovariate:
        covariate_columns_.push_back(target.column);
        break;
      case ColumnKind::kTime:
        break;
    }
  }
  void EmitSegmentsBefore(double t_s) {
    for (; next_segment_ < segments_.size() && segments_[next_segment_].end_s < t_s;
         ++next_segment_) {
      sink_.OnSegment(segments_[next_segment_]);
    }
  }
  void EmitGyro(const double* row, double t_s) {
    GyroSample sample;
    sample.t_s = t_s;
    bool any = false;
    for (const Target& target : gyro_) {
      sample.xi[target.index] = row[target.column];
      any |= !std::isnan(row[target.column]);
    }
    bool others = false;
    for (const Target& target : accel_) {
      sample.accel_g[target.index] = row[target.column] * target.scale;
      others |= !std::isnan(row[target.column]);
    }
    for (const Target& target : temperature_) {
      sample.temperature_degC = row[target.column];
      others |= !std::isnan(row[target.column]);
    }
    EmitCovariates(row, t_s, any);
    if (any) {
      sink_.OnGyro(sample);
    } else if (others) {
      counter_.Count(no_gyro_, t_s, [t_s] { return fmt::format("t_s = {}", t_s); });
    }
  }
  // With every sample of the gyro, and wherever there is a value.
  void EmitCovariates(const double* row, double t_s, bool any) {
    if (covariates_.empty()) return;
    for (std::size_t i = 0; i < covariates_.size(); ++i) {
      covariates_[i] = row[covariate_columns_[i]];
      any |= !std::isnan(covariates_[i]);
    }
    if (any) sink_.OnCovariates(t_s, covariates_);
  }
  void EmitOrientation(const double* row, double t_s) {
    constexpr double kMaxLengthError = 0.01;
    OrientationSample sample;
    sample.t_s = t_s;
    double squares = 0.0;
    int missing = 0;
    for (const Target& target : quaternion_) {
      const double part = row[target.column];
      sample.q_wxyz[target.index] = part;
      squares += part * part;
      missing += std::isnan(part) ? 1 : 0;
    }
    if (missing == 4) return;
    const double length = std::sqrt(squares);
    if (!(std::abs(length - 1.0) <= kMaxLengthError)) {
      counter_.Count(bad_quaternion_, t_s,
                     [&] { return fmt::format("t_s = {}, length {}", t_s, length); });
      return;
    }
    for (double& part : sample.q_wxyz) part /= length;
    sink_.OnOrientation(sample);
  }

  MeasurementSink& sink_;
  std::size_t time_;
  const std::vector<SegmentMark>& segments_;
  std::size_t next_segment_ = 0;
  std::vector<Target> gyro_, accel_, temperature_, angles_, quaternion_, ticks_;
  std::vector<std::size_t> covariate_columns_;
  std::vector<double> covariates_;  // of the row
  DefectCounter counter_;
  std::size_t no_gyro_ = 0, bad_quaternion_ = 0;
};

}  // namespace

void ReplayTable(const std::filesystem::path& table, MeasurementSink& sink,
                 const ReplayProgress& progress) {
  TableReader reader(table);
  sink.OnInfo(reader.info());
  for (const Defect& defect : reader.head().defects()) sink.OnDefect(defect);
  RowEvents events(reader, sink);
  for (TableRows rows = reader.Next(); rows.count() > 0; rows = reader.Next()) {
    for (std::size_t i = 0; i < rows.count(); ++i) events.Emit(rows.row(i));
    if (progress) progress(reader.fraction());
  }
  events.End();
  for (const Defect& defect : reader.defects()) sink.OnDefect(defect);
}

}  // namespace gyrobench::recording
