// Writes a measurement as a measurement table (docs/measurement-table.md), .csv or .csv.gz, as a
// stream.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/measurement.h"
#include "recording/replay.h"

namespace gyrobench::recording {

// The name says the form: .csv or .csv.gz. The file appears under its name when Close is done;
// until then it is <file>.part, and without Close nothing is left behind. Throws DataError.
class TableFile {
 public:
  explicit TableFile(const std::filesystem::path& file);
  ~TableFile();
  TableFile(const TableFile&) = delete;
  TableFile& operator=(const TableFile&) = delete;

  void Append(std::string_view text);
  void EndLine();
  void Close();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

// What is only known at a run's end but stands in a table's head.
struct TableExtras {
  std::vector<SegmentMark> segments;
  std::vector<Defect> defects;
};

struct TableSummary {
  std::int64_t rows = 0;
  // Events left out: more than TableWriter::kReorder_s behind the latest.
  std::int64_t late = 0;
  // Events left out: of an axis that MeasurementInfo does not announce.
  std::int64_t unannounced = 0;
};

// One row for each distinct time, empty fields for what has no value then. Times are written in
// whole microseconds, counts as integers, covariates in their shortest exact form, all else to
// 1e-9: reading the table gives the record's events again. The clock of the sensor unit is kept in
// the column unit_tick_s. Counts of the gyro are those of the source's converter, its zero with
// them (gyro_lsb_zero). Segments and defects that arrive as events are not written, for they come
// after the head: `extras` brings them.
class TableWriter : public MeasurementSink {
 public:
  // Events are put in order within this time: devices are polled in turn, and a bus may be
  // repeating a request.
  static constexpr double kReorder_s = 5.0;

  // The name says the form: .csv or .csv.gz. The file appears under its name when Close is done;
  // until then it is <file>.part, and without Close nothing is left behind. Throws DataError.
  explicit TableWriter(const std::filesystem::path& file, TableExtras extras = {});

  void OnInfo(const MeasurementInfo& info) override;
  void OnGyro(const GyroSample& sample) override;
  void OnCovariates(double t_s, std::span<const double> values) override;
  void OnAngle(const AngleSample& sample) override;
  void OnOrientation(const OrientationSample& sample) override;
  void OnTickPair(const TickPair& pair) override;
  void OnSegment(const SegmentMark&) override {}
  void OnDefect(const Defect&) override {}

  // Writes what is held back and gives the file its name. Throws DataError when the disk is full.
  TableSummary Close();

 private:
  // Places of a row's values.
  enum Slot : std::size_t {
    kGyro = 0,
    kAccel = 3,
    kTemperature = 6,
    kAngle = 7,
    kQuaternion = 10,
    kTick = 14,
    kCovariate = 15  // and one for each further covariate
  };
  enum class Form { kDecimal, kCount, kExact };
  struct Column {
    std::size_t slot = 0;
    Form form = Form::kDecimal;
    std::string name;
  };
  // Values of consecutive slots at one time.
  struct Event {
    std::int64_t time_us = 0;
    std::uint16_t slot = 0;
    std::uint16_t size = 0;
    std::array<double, 7> values = {};
  };

  void AddColumns(const MeasurementInfo& info);
  void WriteHead(const MeasurementInfo& info);
  void Hold(double t_s, std::size_t slot, const double* values, std::size_t size);
  void WriteUpTo(std::int64_t time_us);
  void WriteRow();
  void WriteValue(const Column& column, double value);

  TableFile output_;
  TableExtras extras_;
  std::vector<Column> columns_;
  double gyro_zero_ = 0.0;  // of the counts that are written
  std::size_t covariates_ = 0;
  std::vector<bool> present_ = std::vector<bool>(kCovariate);
  std::vector<Event> held_;
  std::int64_t latest_us_;
  std::int64_t written_us_;
  std::vector<double> row_ = std::vector<double>(kCovariate, kMissing);
  std::int64_t row_us_ = 0;
  bool row_begun_ = false;
  TableSummary summary_;
};

// Writes a record, or another table, as a table; reads it twice, for the head needs what is known
// at the end. Throws DataError. What `progress` throws ends it, and nothing is left behind.
TableSummary ExportTable(const std::filesystem::path& source, const std::filesystem::path& table,
                         const ReplayProgress& progress = {});

}  // namespace gyrobench::recording
