#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "base/unsigned_counts.h"
#include "recording/measurement_table.h"
#include "recording/replay.h"

namespace gyrobench::recording {

namespace {

// Where a column's value goes.
struct Target {
  std::size_t column = 0;
  std::size_t index = 0;
  double zero = 0.0, scale = 1.0;
  double Of(const double* row) const { return (row[column] - zero) * scale; }
};

constexpr const char* kUnsigned = "unsigned_counts";

// Whether the counts of a table's gyro, or accelerometer, are unsigned and nobody said so.
class CountsWatch {
 public:
  void Watch(const std::vector<TableColumn>& columns, ColumnKind kind) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i].kind != kind || !columns[i].IsInCounts() || columns[i].zero != 0.0) continue;
      watched_.push_back({i, static_cast<std::size_t>(columns[i].index)});
      names_ += (names_.empty() ? "" : ", ") + columns[i].name;
    }
  }
  void Add(const double* row, double t_s) {
    for (const auto& [column, axis] : watched_) counts_.Add(axis, t_s, row[column]);
  }
  std::optional<Defect> Found() const {
    if (!counts_.Recognised()) return std::nullopt;
    const auto columns = static_cast<std::int64_t>(watched_.size());
    return Defect{kUnsigned, counts_.samples() / columns, counts_.first_crossing_s(), names_};
  }

 private:
  UnsignedCounts counts_;
  std::vector<std::pair<std::size_t, std::size_t>> watched_;  // column, axis
  std::string names_;
};

// Rows of a table as events of a measurement.
class RowEvents {
 public:
  RowEvents(const TableReader& reader, MeasurementSink& sink)
      : sink_(sink),
        head_(reader.head()),
        time_(reader.head().time_column()),
        segments_(reader.head().segments()) {
    const std::vector<TableColumn>& columns = reader.columns();
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const TableColumn& column = columns[i];
      Add({i, static_cast<std::size_t>(column.index), column.zero, column.scale}, column.kind);
    }
    if (!reader.info().gyro_lsb_zero) gyro_counts_.Watch(columns, ColumnKind::kGyro);
    if (!reader.info().accel_lsb_zero) accel_counts_.Watch(columns, ColumnKind::kAccel);
    covariates_.resize(covariate_columns_.size());
    no_gyro_ = counter_.Add("no_gyro");
    bad_quaternion_ = counter_.Add("bad_quaternion");
  }

  void Emit(const double* row) {
    const double t_s = row[time_];
    EmitSegmentsBefore(t_s);
    gyro_counts_.Add(row, t_s);
    accel_counts_.Add(row, t_s);
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
    for (const CountsWatch* counts : {&gyro_counts_, &accel_counts_}) {
      const std::optional<Defect> found = counts->Found();
      if (found && !IsInHead(*found)) sink_.OnDefect(*found);
    }
  }

 private:
  // A table written from one that had this defect says it already.
  bool IsInHead(const Defect& defect) const {
    return std::any_of(head_.defects().begin(), head_.defects().end(), [&](const Defect& said) {
      return said.kind == defect.kind && said.where == defect.where;
    });
  }
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
      sample.xi[target.index] = target.Of(row);
      any |= !std::isnan(row[target.column]);
    }
    bool others = false;
    for (const Target& target : accel_) {
      sample.accel_g[target.index] = target.Of(row);
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
  const TableHead& head_;
  CountsWatch gyro_counts_, accel_counts_;
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
