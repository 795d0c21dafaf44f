#include "recording/measurement_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "recording/decimal.h"
#include "recording/plausible.h"
#include "recording/table_words.h"

namespace gyrobench::recording {

namespace {

constexpr std::size_t kBatchValues = std::size_t{16} * 1024;  // 128 kB: stays in the cache
constexpr std::size_t kMinRows = 128;
constexpr std::size_t kMaxGroup = 64;  // rows with one time stamp that are kept

std::string Shown(std::string_view text) {
  constexpr std::size_t kShown = 24;
  std::string shown(text.substr(0, kShown));
  std::replace_if(
      shown.begin(), shown.end(), [](char c) { return c < ' ' || c >= 127; }, '?');
  return text.size() > kShown ? shown + "..." : shown;
}

std::size_t RowsPerBatch(std::size_t columns) {
  return std::max(kMinRows, kBatchValues / std::max<std::size_t>(1, columns));
}

}  // namespace

TableReader::TableReader(const std::filesystem::path& file)
    : file_(file.string()), lines_(OpenByteSource(file)), head_(file_), decimal_commas_(file_) {
  ReadHead();
  width_ = head_.columns().size();
  capacity_ = RowsPerBatch(width_);
  values_.resize(capacity_ * width_);
  repeated_ = counter_.Add("repeated_time");
  ragged_ = counter_.Add("ragged_line");
  no_time_ = counter_.Add("no_time");
  too_long_ = counter_.Add("line_too_long");
  unparsable_ = not_a_number_ = 0;
  for (std::size_t i = 0; i < width_; ++i) {
    const std::size_t number = counter_.Add("unparsable");
    if (i == 0) unparsable_ = number;
  }
  for (std::size_t i = 0; i < width_; ++i) {
    const std::size_t number = counter_.Add("not_a_number");
    if (i == 0) not_a_number_ = number;
  }
}

std::string TableReader::Line() const { return fmt::format("line {}", line_); }

bool TableReader::NextHeadLine(std::string_view& line) {
  while (at_ == end_) {
    LineBlock block;
    if (!lines_.Next(block)) return false;
    if (block.after_long_line) {
      throw DataError(
          fmt::format("{}:{}: no measurement table: a line of over {} bytes before any data", file_,
                      line_ + 1, LineBuffer::kMaxLine));
    }
    at_ = block.begin;
    end_ = block.end;
  }
  ++line_;
  const auto* feed =
      static_cast<const char*>(std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_)));
  line = Trim({at_, static_cast<std::size_t>(feed - at_)});
  at_ = feed + 1;
  return true;
}

void TableReader::ReadHead() {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  std::string_view line;
  while (NextHeadLine(line)) {
    if (line_ == 1 && line.starts_with(kByteOrderMark)) line.remove_prefix(kByteOrderMark.size());
    if (line.empty()) continue;
    if (line.front() != '#') return head_.Header(line, line_);
    head_.Comment(line, line_);
  }
  const std::optional<Defect>& damage = lines_.source().damage();
  throw DataError(
      fmt::format("{}: no measurement table: expected a header line with t_s, found {}; "
                  "was it copied whole?",
                  file_,
                  damage       ? damage->kind + " at " + damage->where
                  : line_ == 0 ? "an empty file"
                               : "comments only"));
}

bool TableReader::NextBlock() {
  LineBlock block;
  if (!lines_.Next(block)) return false;
  if (block.after_long_line) {
    ++line_;
    counter_.Count(too_long_, group_t_s_, [this] { return Line(); });
  }
  at_ = block.begin;
  end_ = block.end;
  return true;
}

TableRows TableReader::Next() {
  // The rows of the latest time stamp were held back until it is known that no more of them come.
  std::copy(values_.begin() + static_cast<std::ptrdiff_t>(given_ * width_),
            values_.begin() + static_cast<std::ptrdiff_t>(rows_ * width_), values_.begin());
  rows_ -= given_;
  group_ = 0;
  while (!ended_ && rows_ < capacity_) {
    if (at_ != end_) {
      ParseLine();
    } else if (!NextBlock()) {
      ended_ = true;
      decimal_commas_.End();
      SpreadGroup(std::numeric_limits<double>::infinity());
      group_ = rows_;
    }
  }
  given_ = ended_ ? rows_ : group_;
  return {{values_.data(), given_ * width_}, width_};
}

void TableReader::ParseLine() {
  ++line_;
  double* row = values_.data() + rows_ * width_;
  if (ParsePlain(row)) return Accept(row);
  const auto* feed =
      static_cast<const char*>(std::memchr(at_, '\n', static_cast<std::size_t>(end_ - at_)));
  const std::string_view line(at_, static_cast<std::size_t>(feed - at_));
  at_ = feed + 1;
  if (ParseSlowly(line, row)) Accept(row);
}

// The common case: every field empty or a plain decimal, as many as there are columns. False, with
// nothing read, in any other.
bool TableReader::ParsePlain(double* row) {
  const char* p = at_;
  const std::size_t last = width_ - 1;
  for (std::size_t i = 0; i <= last; ++i) {
    const char stop = i < last ? ',' : '\n';
    if (*p == stop || (*p == '\r' && stop == '\n')) {
      row[i] = kMissing;
    } else if (p = ReadPlainDecimal(p, row[i]); p == nullptr) {
      return false;
    }
    if (*p == '\r') ++p;
    if (*p != stop) return false;
    ++p;
  }
  at_ = p;
  return true;
}

bool TableReader::ParseSlowly(std::string_view line, double* row) {
  if (Trim(line).empty()) return false;
  const auto fields = static_cast<std::size_t>(std::count(line.begin(), line.end(), ',')) + 1;
  if (fields != width_) {
    counter_.Count(ragged_, group_t_s_, [&] {
      return fmt::format("{}: {} fields, expected {}", Line(), fields, width_);
    });
    decimal_commas_.Look(line, line_, width_);
    return false;
  }
  for (std::size_t i = 0; i < width_; ++i) {
    const std::size_t comma = std::min(line.find(','), line.size());
    row[i] = ParseField(Unquote(line.substr(0, comma)), i, group_t_s_);
    line.remove_prefix(std::min(comma + 1, line.size()));
  }
  return true;
}

// `t_s`: the latest time, for the report.
double TableReader::ParseField(std::string_view field, std::size_t column, double t_s) {
  if (field.empty()) return kMissing;
  const std::string_view digits = field.front() == '+' ? field.substr(1) : field;
  const char* end = digits.data() + digits.size();
  double value = kMissing;
  const auto [stop, error] = std::from_chars(digits.data(), end, value);
  const auto where = [&] {
    return fmt::format("{}, column {}: '{}'", Line(), head_.columns()[column].name, Shown(field));
  };
  if (error != std::errc() || stop != end) {
    counter_.Count(unparsable_ + column, t_s, where);
    return kMissing;
  }
  if (!IsPlausible(value)) {
    counter_.Count(not_a_number_ + column, t_s, where);
    return kMissing;
  }
  return value;
}

namespace {

bool IsWhole(double number) {
  const double rounding = 1e-4 + 4.0 * std::numeric_limits<double>::epsilon() * std::fabs(number);
  return std::fabs(number - std::round(number)) < rounding;
}

}  // namespace

void TableReader::Accept(double* row) {
  const double t_s = row[head_.time_column()];
  decimal_commas_.Accept();
  if (!(std::abs(t_s) <= kLatestTime_s)) {
    counter_.Count(no_time_, group_t_s_, [this] { return Line(); });
  } else if (std::isnan(group_t_s_)) {
    group_t_s_ = t_s;
    group_ = rows_++;
  } else if (t_s > group_t_s_) {
    if (rows_ - group_ > 1) SpreadGroup(t_s);
    packets_.Take(t_s, false);
    interval_s_ = t_s - group_t_s_;
    group_t_s_ = t_s;
    group_ = rows_++;
  } else if (t_s == group_t_s_) {
    AcceptRepeated(row);
  } else {
    throw DataError(fmt::format(
        "{}:{}: time goes backwards: t_s = {:.9g} after {:.9g}; expected times that grow; sort the "
        "lines, or cut the table in two where the clock was set",
        file_, line_, t_s, group_t_s_));
  }
}

bool TableReader::IsOfGyro(std::size_t column) const {
  return head_.columns()[column].kind == ColumnKind::kGyro;
}

// Of two rows of one time: what one has and the other has not, as where gyro and reference have
// lines of their own, is one row. Of a packet two samples may be the same to the digit.
bool TableReader::Complement(const double* row, double* latest) const {
  bool fills = false;
  for (std::size_t i = 0; i < width_; ++i) {
    if (std::isnan(row[i])) continue;
    if (std::isnan(latest[i])) {
      fills = true;
    } else if (row[i] != latest[i] || (packets_.Many() && IsOfGyro(i))) {
      return false;
    }
  }
  if (!fills) return false;
  for (std::size_t i = 0; i < width_; ++i) {
    if (!std::isnan(row[i])) latest[i] = row[i];
  }
  return true;
}

void TableReader::AcceptRepeated(const double* row) {
  if (rows_ > group_ && Complement(row, values_.data() + (rows_ - 1) * width_)) return;
  counter_.Count(repeated_, group_t_s_, [this] { return Line(); });
  const double* latest = row - width_;
  bool same = rows_ > group_;
  for (std::size_t i = 0; same && i < width_; ++i) same = std::isnan(row[i]) || row[i] == latest[i];
  if ((same && !packets_.Many()) || rows_ - group_ >= kMaxGroup) return;
  packets_.Take(group_t_s_, true);
  ++rows_;
}

void TableReader::Packets::Take(double t_s, bool repeated) {
  constexpr double kMemory = 200.0;
  rows_ = std::min(rows_ + 1.0, kMemory);
  share_repeated_ += ((repeated ? 1.0 : 0.0) - share_repeated_) / rows_;
  constexpr double kFinest_s = 1e-6;
  while (digit_s_ > kFinest_s && !IsWhole(t_s / digit_s_)) digit_s_ *= 0.1;
}

bool TableReader::Packets::Many() const {
  constexpr double kLeastRows = 64.0, kMany = 0.15;
  return rows_ >= kLeastRows && share_repeated_ > kMany;
}

bool TableReader::Packets::Likely(double step_s) const {
  constexpr double kDigits = 3.5;
  return Many() && step_s > kDigits * digit_s_;
}

// The rows of one time stamp are put evenly between it and the next, at most as far apart as the
// stamps before it: a pause that follows is no reason to move a sample into it. Those of a packet
// stay together.
void TableReader::SpreadGroup(double next_t_s) {
  constexpr double kTogether_s = 1e-6;
  const std::size_t count = rows_ - group_;
  if (count < 2) return;
  double step_s = (next_t_s - group_t_s_) / static_cast<double>(count);
  if (interval_s_ < step_s) step_s = interval_s_;
  if (!std::isfinite(step_s)) step_s = 0.0;
  if (packets_.Likely(next_t_s - group_t_s_)) step_s = std::min(step_s, kTogether_s);
  for (std::size_t i = 0; i < count; ++i) {
    values_[(group_ + i) * width_ + head_.time_column()] =
        group_t_s_ + static_cast<double>(i) * step_s;
  }
}

std::vector<Defect> TableReader::defects() const {
  std::vector<Defect> found = counter_.Found();
  if (lines_.source().damage()) found.push_back(*lines_.source().damage());
  return found;
}

}  // namespace gyrobench::recording
