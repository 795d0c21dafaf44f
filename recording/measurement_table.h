// Reads measurement tables (docs/measurement-table.md), .csv and .csv.gz, as a stream: memory does
// not depend on the length of the file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/measurement.h"
#include "recording/decimal_commas.h"
#include "recording/defect_counter.h"
#include "recording/line_buffer.h"
#include "recording/table_columns.h"

namespace gyrobench::recording {

// A stretch of rows, one after the other; missing values are NaN. Units are the columns'.
struct TableRows {
  std::span<const double> values;  // count x columns
  std::size_t columns = 0;
  std::size_t count() const { return columns == 0 ? 0 : values.size() / columns; }
  const double* row(std::size_t i) const { return values.data() + i * columns; }
};

// What is mended or left out, each counted with the line of the first one:
//   repeated_time   a time stamp again, but of a row that only fills what the one before left
//                   empty: the two are one. The same row again is left out. Different rows share
//                   the time up to the next stamp, evenly, at most one earlier interval apart, or
//                   stay together where many rows repeat the time and the next stamp is several of
//                   its digits away, as a serial adapter hands rows over; 64 are kept
//   ragged_line     too few or too many fields: left out, for its columns may have moved
//   no_time         no time in a line, or one beyond 1e11 s: left out
//   unparsable      a field that is no number: missing, the other fields are read
//   not_a_number    nan, inf or beyond 1e30: missing
//   line_too_long   over LineBuffer::kMaxLine bytes: left out
//   truncated_gzip, damaged_gzip   what comes before is read, up to the last whole line
// Time that goes backwards is an error, for no one can say which side is right, and so are numbers
// with a decimal comma.
class TableReader {
 public:
  // Reads the head. Throws DataError "file:line: what, expected ...".
  explicit TableReader(const std::filesystem::path& file);

  const MeasurementInfo& info() const { return head_.info(); }
  const std::vector<TableColumn>& columns() const { return head_.columns(); }
  const TableHead& head() const { return head_; }
  // The next rows, none at the end. They hold until the next call. Throws DataError.
  TableRows Next();
  // Found so far.
  std::vector<Defect> defects() const;
  // Of the file, 0..1.
  double fraction() const { return lines_.source().fraction(); }

 private:
  void ReadHead();
  bool NextBlock();
  bool NextHeadLine(std::string_view& line);
  void ParseLine();
  bool ParsePlain(double* row);
  bool ParseSlowly(std::string_view line, double* row);
  double ParseField(std::string_view field, std::size_t column, double t_s);
  void Accept(double* row);
  bool IsOfGyro(std::size_t column) const;
  bool Complement(const double* row, double* latest) const;
  void AcceptRepeated(const double* row);
  void SpreadGroup(double next_t_s);
  std::string Line() const;

  // Of the last rows, whether they came several at once, and not by a clock that is coarser than
  // they follow each other: that steps by one of its digits.
  class Packets {
   public:
    void Take(double t_s, bool repeated);
    // Many rows that are not the same repeat the time of the one before.
    bool Many() const;
    // And a step of this length follows.
    bool Likely(double step_s) const;

   private:
    double rows_ = 0.0, share_repeated_ = 0.0;
    double digit_s_ = 1.0;  // last digit of all times so far
  };

  std::string file_;
  LineBuffer lines_;
  TableHead head_;
  const char* at_ = nullptr;  // unread lines of the block
  const char* end_ = nullptr;
  std::int64_t line_ = 0;  // number of the line last begun
  bool ended_ = false;

  std::size_t width_ = 0;     // columns
  std::size_t capacity_ = 0;  // rows
  std::vector<double> values_;
  std::size_t rows_ = 0;   // in values_
  std::size_t given_ = 0;  // of them handed out
  std::size_t group_ = 0;  // first row of those that share the latest time stamp
  double group_t_s_ = kMissing;
  double interval_s_ = kMissing;  // between the latest two different stamps
  Packets packets_;

  DecimalCommas decimal_commas_;
  DefectCounter counter_;
  std::size_t repeated_ = 0, ragged_ = 0, no_time_ = 0, too_long_ = 0;
  std::size_t unparsable_ = 0, not_a_number_ = 0;  // of the first column; the others follow
};

}  // namespace gyrobench::recording
