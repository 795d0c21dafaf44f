#include "cli/corrected_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <deque>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "base/error.h"
#include "recording/decimal_commas.h"
#include "recording/line_buffer.h"
#include "recording/table_columns.h"
#include "recording/table_words.h"
#include "recording/table_writer.h"

namespace gyrobench::cli {
namespace {

using recording::ColumnKind;
using recording::TableColumn;
using recording::Trim;

constexpr const char* kMadeBy = "corrected_by";

// NaN where the field is empty or no number.
double Value(std::string_view field) {
  field = recording::Unquote(field);
  if (field.starts_with('+')) field.remove_prefix(1);
  double value = kMissing;
  const auto [stop, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || stop != field.data() + field.size()) return kMissing;
  return std::isfinite(value) ? value : kMissing;
}

// The key of a comment "# key = value", empty where it is none.
std::string_view KeyOf(std::string_view comment) {
  const std::size_t equals = comment.find('=');
  return equals == std::string_view::npos ? "" : Trim(comment.substr(1, equals - 1));
}

void Split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

// Lines of a file, one by one, numbered.
class Lines {
 public:
  Lines(const std::filesystem::path& file, std::string name)
      : file_(std::move(name)), buffer_(recording::OpenByteSource(file)) {}
  // Without its line feed.
  bool Next(std::string_view& line) {
    while (at_ == end_) {
      recording::LineBlock block;
      if (!buffer_.Next(block)) return false;
      if (block.after_long_line) {
        throw DataError(fmt::format("{}:{}: a line of over {} bytes", file_, number_ + 1,
                                    recording::LineBuffer::kMaxLine));
      }
      at_ = block.begin;
      end_ = block.end;
    }
    const auto* feed =
        static_cast<const char*>(std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_)));
    line = {at_, static_cast<std::size_t>(feed - at_)};
    if (line.ends_with('\r')) line.remove_suffix(1);
    at_ = feed + 1;
    ++number_;
    return true;
  }
  std::int64_t number() const { return number_; }
  const recording::ByteSource& source() const { return buffer_.source(); }

 private:
  std::string file_;
  recording::LineBuffer buffer_;
  const char* at_ = nullptr;
  const char* end_ = nullptr;
  std::int64_t number_ = 0;
};

class TableCorrection {
 public:
  TableCorrection(const std::filesystem::path& table, const std::string& name,
                  const std::filesystem::path& output)
      : file_(name), lines_(table, name), head_(file_), decimal_commas_(file_), out_(output) {}

  CorrectedTable Run(const calibration::Calibration& calibration,
                     const calibration::CorrectorOptions& options, const std::string& made_by,
                     const std::function<void(double fraction)>& progress) {
    CopyHead(made_by);
    corrector_.emplace(calibration, head_.info(), options);
    std::string_view line;
    while (lines_.Next(line)) {
      if (Trim(line).empty()) continue;
      Take(line);
      Give();
      if ((result_.rows & 0xFFF) == 0) progress(lines_.source().fraction());
    }
    if (result_.rows == 0) {
      throw DataError(
          fmt::format("{}: expected rows below the header, found none; was it copied "
                      "whole?",
                      file_));
    }
    decimal_commas_.End();
    corrector_->End();
    Give();
    out_.Close();
    result_.correction = corrector_->Report();
    if (const auto& damage = lines_.source().damage()) {
      result_.correction.remarks.push_back(fmt::format(
          "{}: {} at {}: what came before it was corrected", file_, damage->kind, damage->where));
    }
    return std::move(result_);
  }

 private:
  struct Row {
    std::string text;
    bool has_sample = false;
  };

  void CopyHead(const std::string& made_by) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    std::string_view line;
    while (lines_.Next(line)) {
      if (lines_.number() == 1 && line.starts_with(kByteOrderMark))
        line.remove_prefix(kByteOrderMark.size());
      line = Trim(line);
      if (line.empty()) continue;
      if (line.front() != '#') return Header(line, made_by);
      head_.Comment(line, lines_.number());
      if (KeyOf(line) == kMadeBy) {
        throw DataError(fmt::format(
            "{}:{}: this table is corrected already; apply the calibration to the table that it "
            "was made from",
            file_, lines_.number()));
      }
      const std::string_view key = KeyOf(line);
      if (key != "gyro_lsb_per_deg_s" && key != "gyro_lsb_zero") PutLine(line);
    }
    throw DataError(fmt::format(
        "{}: no measurement table: expected a header line with t_s, found {}; was it copied whole?",
        file_, lines_.number() == 0 ? "an empty file" : "comments only"));
  }

  void Header(std::string_view line, const std::string& made_by) {
    head_.Header(line, lines_.number());
    PutLine(fmt::format("# {} = {}", kMadeBy, made_by));
    const std::vector<TableColumn>& columns = head_.columns();
    axis_of_.assign(columns.size(), -1);
    covariates_.assign(head_.info().covariates.size(), kMissing);
    std::string names;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const bool gyro = columns[i].kind == ColumnKind::kGyro;
      if (gyro) axis_of_[i] = columns[i].index;
      names += i > 0 ? "," : "";
      names += gyro ? fmt::format("gyro_{}_deg_s", "xyz"[columns[i].index]) : columns[i].name;
    }
    PutLine(names);
  }

  void PutLine(std::string_view line) {
    out_.Append(line);
    out_.EndLine();
  }

  void Take(std::string_view line) {
    Split(line, fields_);
    ++result_.rows;
    Row& row = Push();
    const bool whole = fields_.size() == axis_of_.size();
    if (whole) {
      decimal_commas_.Accept();
    } else {
      decimal_commas_.Look(line, lines_.number(), axis_of_.size());
    }
    const double t_s = whole ? Value(fields_[head_.time_column()]) : kMissing;
    row.has_sample = !std::isnan(t_s);
    if (!row.has_sample) {
      ++result_.without_time;
      row.text.assign(axis_of_.size() - 1, ',');
      return;
    }
    if (t_s < last_t_s_) {
      throw DataError(fmt::format(
          "{}:{}: time goes backwards: t_s = {:.9g} after {:.9g}; expected times that grow", file_,
          lines_.number(), t_s, last_t_s_));
    }
    last_t_s_ = t_s;
    row.text.assign(line);
    row.has_sample = !IsOfOthersAlone();
    if (row.has_sample) corrector_->Add(Sample(t_s), covariates_);
  }

  // A reading of a reference, or of the unit's clock, that is logged by itself: no sample of the
  // gyro is missing there.
  bool IsOfOthersAlone() const {
    bool others = false;
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (recording::Unquote(fields_[i]).empty() || i == head_.time_column()) continue;
      const ColumnKind kind = head_.columns()[i].kind;
      const bool reads = kind == ColumnKind::kStandAngle || kind == ColumnKind::kSensorAngle ||
                         kind == ColumnKind::kQuaternion || kind == ColumnKind::kUnitTick;
      if (!reads) return false;
      others = true;
    }
    return others;
  }

  GyroSample Sample(double t_s) {
    GyroSample sample;
    sample.t_s = t_s;
    const std::vector<TableColumn>& columns = head_.columns();
    std::size_t covariate = 0;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      const TableColumn& column = columns[i];
      const auto index = static_cast<std::size_t>(column.index);
      if (column.kind == ColumnKind::kGyro)
        sample.xi.at(index) = column.Measured(Value(fields_[i]));
      if (column.kind == ColumnKind::kAccel)
        sample.accel_g.at(index) = column.Measured(Value(fields_[i]));
      if (column.kind == ColumnKind::kTemperature) sample.temperature_degC = Value(fields_[i]);
      if (column.kind == ColumnKind::kCovariate) covariates_[covariate++] = Value(fields_[i]);
    }
    return sample;
  }

  // Rows that are done with lend their memory to new ones.
  Row& Push() {
    if (spare_.empty()) {
      rows_.emplace_back();
    } else {
      rows_.push_back(std::move(spare_.back()));
      spare_.pop_back();
    }
    return rows_.back();
  }

  void Give() {
    Vector3 rate;
    while (!rows_.empty()) {
      Row& row = rows_.front();
      if (!row.has_sample) {
        PutLine(row.text);
      } else if (corrector_->Next(&rate)) {
        PutRow(row.text, rate);
      } else {
        return;
      }
      spare_.push_back(std::move(row));
      rows_.pop_front();
    }
  }

  // Rates to 1e-7 deg/s: 0.0004 deg in an hour, were all rounded the same way.
  void PutRow(std::string_view text, const Vector3& rate) {
    Split(text, fields_);
    for (std::size_t i = 0; i < fields_.size(); ++i) {
      if (i > 0) out_.Append(",");
      if (axis_of_[i] < 0) {
        out_.Append(fields_[i]);
        continue;
      }
      const double value = rate[static_cast<std::size_t>(axis_of_[i])];
      if (std::isnan(value)) continue;
      std::array<char, 48> digits;
      const auto end = fmt::format_to_n(digits.data(), digits.size(), "{:.7f}", value);
      out_.Append({digits.data(), std::min(end.size, digits.size())});
    }
    out_.EndLine();
  }

  std::string file_;
  Lines lines_;
  recording::TableHead head_;
  recording::DecimalCommas decimal_commas_;
  recording::TableFile out_;
  std::optional<calibration::Corrector> corrector_;
  std::vector<int> axis_of_;  // column by column: SensorAxis of a gyro's, -1 of others
  std::vector<double> covariates_;
  std::vector<std::string_view> fields_;
  std::deque<Row> rows_;
  std::vector<Row> spare_;
  double last_t_s_ = -std::numeric_limits<double>::infinity();
  CorrectedTable result_;
};

}  // namespace

CorrectedTable WriteCorrectedTable(const std::filesystem::path& table, const std::string& name,
                                   const std::filesystem::path& output,
                                   const calibration::Calibration& calibration,
                                   const calibration::CorrectorOptions& options,
                                   const std::string& made_by,
                                   const std::function<void(double fraction)>& progress) {
  return TableCorrection(table, name, output).Run(calibration, options, made_by, progress);
}

}  // namespace gyrobench::cli
