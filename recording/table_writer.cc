#include "recording/table_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include "recording/replay.h"

namespace gyrobench::recording {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
constexpr std::size_t kMaxHeld = 1u << 17;  // bounds the memory where times stand still
constexpr int kDecimals = 9;

// Keys and values go on one line.
std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

// 9 decimals without the zeros at the end; where a double has no room for them, its shortest form.
char* AppendDecimal(char* out, char* end, double value) {
  if (std::abs(value) >= 1e6) return std::to_chars(out, end, value).ptr;
  char* stop = std::to_chars(out, end, value, std::chars_format::fixed, kDecimals).ptr;
  while (stop[-1] == '0') --stop;
  if (stop[-1] == '.') --stop;
  return stop;
}

}  // namespace

TableWriter::TableWriter(const fs::path& file, TableExtras extras)
    : output_(file), extras_(std::move(extras)), latest_us_(kNever), written_us_(kNever) {}

void TableWriter::AddColumns(const MeasurementInfo& info) {
  constexpr std::array<const char*, 3> kUnits = {"lsb", "deg_s", "rad_s"};
  constexpr std::array<const char*, 3> kSensorAxes = {"x", "y", "z"};
  constexpr std::array<const char*, 3> kStandAxes = {"outer", "middle", "inner"};
  constexpr std::array<const char*, 4> kQuaternionParts = {"ref_qw", "ref_qx", "ref_qy", "ref_qz"};
  const Form gyro_form = info.gyro_unit == RateUnit::kLsb ? Form::kCount : Form::kDecimal;
  const char* unit = kUnits.at(static_cast<std::size_t>(info.gyro_unit));
  for (std::size_t i = 0; i < 3; ++i) {
    if (info.gyro_present.at(i)) {
      columns_.push_back(
          {kGyro + i, gyro_form, fmt::format("gyro_{}_{}", kSensorAxes.at(i), unit)});
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    if (info.accel_present.at(i)) {
      columns_.push_back(
          {kAccel + i, Form::kDecimal, fmt::format("accel_{}_g", kSensorAxes.at(i))});
    }
  }
  if (info.temperature_present) columns_.push_back({kTemperature, Form::kDecimal, "temp_degC"});
  for (std::size_t i = 0; i < 3; ++i) {
    if (info.reference == ReferenceKind::kStandAngles && info.stand_axis_present.at(i)) {
      columns_.push_back({kAngle + i, Form::kDecimal, fmt::format("ref_{}_deg", kStandAxes.at(i))});
    }
  }
  if (info.reference == ReferenceKind::kSensorAngle) {
    const auto axis = static_cast<std::size_t>(info.reference_axis);
    columns_.push_back(
        {kAngle + axis, Form::kDecimal, fmt::format("ref_angle_{}_deg", kSensorAxes.at(axis))});
  }
  for (std::size_t i = 0; i < 4 && info.reference == ReferenceKind::kOrientation; ++i) {
    columns_.push_back({kQuaternion + i, Form::kDecimal, kQuaternionParts.at(i)});
  }
  columns_.push_back({kTick, Form::kDecimal, "unit_tick_s"});
  for (std::size_t i = 0; i < info.covariates.size(); ++i) {
    columns_.push_back({kCovariate + i, Form::kExact, info.covariates[i]});
  }
  covariates_ = info.covariates.size();
  present_.resize(kCovariate + covariates_);
  row_.resize(kCovariate + covariates_, kMissing);
  for (const Column& column : columns_) present_.at(column.slot) = true;
}

void TableWriter::WriteHead(const MeasurementInfo& info) {
  const auto key = [this](const std::string& name, const std::string& value) {
    output_.Append(OneLine(fmt::format("# {} = {}", name, value)));
    output_.EndLine();
  };
  const auto number = [&key](const char* name, const std::optional<double>& value) {
    if (value) key(name, fmt::format("{}", *value));
  };
  number("site_latitude_deg", info.site_latitude_deg);
  if (info.site_latitude_deg || info.site_heading_deg != 0.0) {
    number("site_heading_deg", info.site_heading_deg);
  }
  StandGeometry geometry = info.geometry;
  for (const GeometryAngle& angle : AnglesOf(geometry)) {
    if (*angle.value_deg != 0.0) number(angle.name, *angle.value_deg);
  }
  if (info.gyro_unit == RateUnit::kLsb) number("gyro_lsb_per_deg_s", info.gyro_units_per_deg_s);
  if (info.gyro_unit == RateUnit::kLsb) number("gyro_lsb_zero", info.gyro_lsb_zero);
  // Acceleration in g is written without it; counts that cannot become g stay as they are.
  if (info.accel_present == std::array<bool, 3>{}) number("accel_lsb_zero", info.accel_lsb_zero);
  number("ref_scale_uncertainty", info.reference_uncertainty.scale);
  number("ref_eccentricity_deg", info.reference_uncertainty.eccentricity_deg);
  number("ref_alignment_deg", info.reference_uncertainty.alignment_deg);
  number("gear_ratio", info.gear_ratio);
  number("stop_accuracy_deg", info.stop_accuracy_deg);
  if (info.gyro_delay_s != 0.0) number("gyro_delay_s", info.gyro_delay_s);
  if (info.reference_delay_s != 0.0) number("ref_delay_s", info.reference_delay_s);
  if (!info.sensor.empty()) key("sensor", info.sensor);
  // A table whose times run on over a restart of the unit belongs to no one power-on.
  const bool restarted = std::ranges::any_of(
      extras_.defects, [](const Defect& defect) { return defect.kind == kUnitRestarted; });
  if (!info.power_on.empty() && !restarted) key("power_on", info.power_on);
  for (const auto& [name, value] : info.notes) key(name, value);
  for (const SegmentMark& mark : extras_.segments) {
    key("segment",
        fmt::format("{:.6f} {:.6f} {} {}", mark.begin_s, mark.end_s, mark.kind, mark.name));
  }
  for (const Defect& defect : extras_.defects) {
    key("defect",
        fmt::format("{} {} {} {}", defect.kind, defect.count, defect.first_t_s, defect.where));
  }
  output_.Append("t_s");
  for (const Column& column : columns_) output_.Append("," + column.name);
  output_.EndLine();
}

void TableWriter::OnInfo(const MeasurementInfo& info) {
  if (info.gyro_unit == RateUnit::kLsb) gyro_zero_ = info.gyro_lsb_zero.value_or(0.0);
  AddColumns(info);
  WriteHead(info);
}

void TableWriter::OnGyro(const GyroSample& sample) {
  const std::array<double, 7> values = {sample.xi[0] + gyro_zero_, sample.xi[1] + gyro_zero_,
                                        sample.xi[2] + gyro_zero_, sample.accel_g[0],
                                        sample.accel_g[1],         sample.accel_g[2],
                                        sample.temperature_degC};
  Hold(sample.t_s, kGyro, values.data(), values.size());
}

void TableWriter::OnAngle(const AngleSample& sample) {
  if (sample.axis < 0 || sample.axis > 2 ||
      !present_.at(kAngle + static_cast<std::size_t>(sample.axis))) {
    ++summary_.unannounced;
    return;
  }
  Hold(sample.t_s, kAngle + static_cast<std::size_t>(sample.axis), &sample.angle_deg, 1);
}

// An event has room for a few values: covariates come as several at one time.
void TableWriter::OnCovariates(double t_s, std::span<const double> values) {
  constexpr std::size_t kRoom = std::tuple_size_v<decltype(Event::values)>;
  const std::size_t known = std::min(values.size(), covariates_);
  if (known < values.size()) ++summary_.unannounced;
  for (std::size_t i = 0; i < known; i += kRoom) {
    Hold(t_s, kCovariate + i, &values[i], std::min(kRoom, known - i));
  }
}

void TableWriter::OnOrientation(const OrientationSample& sample) {
  if (!present_[kQuaternion]) {
    ++summary_.unannounced;
    return;
  }
  Hold(sample.t_s, kQuaternion, sample.q_wxyz.data(), sample.q_wxyz.size());
}

void TableWriter::OnTickPair(const TickPair& pair) { Hold(pair.host_s, kTick, &pair.tick_s, 1); }

// Half of what is held is written at a time, so that sorting costs little an event.
void TableWriter::Hold(double t_s, std::size_t slot, const double* values, std::size_t size) {
  constexpr auto kReorder_us = static_cast<std::int64_t>(kReorder_s * 1e6);
  Event event;
  event.time_us = std::llround(t_s * 1e6);
  event.slot = static_cast<std::uint16_t>(slot);
  event.size = static_cast<std::uint16_t>(size);
  std::copy_n(values, size, event.values.begin());
  if (event.time_us < written_us_) {
    ++summary_.late;
    return;
  }
  latest_us_ = std::max(latest_us_, event.time_us);
  held_.push_back(event);
  const bool long_enough = latest_us_ - held_.front().time_us > 2 * kReorder_us;
  if (long_enough) WriteUpTo(latest_us_ - kReorder_us);
  if (held_.size() >= kMaxHeld) WriteUpTo(latest_us_);
}

// Writes the events before `time_us` in order, and keeps the others in order.
void TableWriter::WriteUpTo(std::int64_t time_us) {
  std::stable_sort(held_.begin(), held_.end(),
                   [](const Event& a, const Event& b) { return a.time_us < b.time_us; });
  auto event = held_.begin();
  for (; event != held_.end() && event->time_us < time_us; ++event) {
    const bool taken =
        std::any_of(row_.begin() + event->slot, row_.begin() + event->slot + event->size,
                    [](double value) { return !std::isnan(value); });
    if (row_begun_ && (event->time_us != row_us_ || taken)) WriteRow();
    row_us_ = event->time_us;
    row_begun_ = true;
    std::copy_n(event->values.begin(), event->size, row_.begin() + event->slot);
  }
  if (row_begun_) WriteRow();
  written_us_ = std::max(written_us_, time_us);
  held_.erase(held_.begin(), event);
}

void TableWriter::WriteValue(const Column& column, double value) {
  std::array<char, 64> text;
  text[0] = ',';
  char* out = text.data() + 1;
  char* end = text.data() + text.size();
  if (column.form == Form::kCount && value == std::trunc(value) && std::abs(value) < 1e15) {
    out = std::to_chars(out, end, static_cast<std::int64_t>(value)).ptr;
  } else if (column.form == Form::kExact && !std::isnan(value)) {
    out = std::to_chars(out, end, value).ptr;
  } else if (!std::isnan(value)) {
    out = AppendDecimal(out, end, value);
  }
  output_.Append({text.data(), static_cast<std::size_t>(out - text.data())});
}

void TableWriter::WriteRow() {
  std::array<char, 64> text;
  const std::int64_t magnitude_us = std::abs(row_us_);
  const auto stop = fmt::format_to_n(text.data(), text.size(), "{}{}.{:06}", row_us_ < 0 ? "-" : "",
                                     magnitude_us / 1'000'000, magnitude_us % 1'000'000);
  output_.Append({text.data(), stop.size});
  for (const Column& column : columns_) WriteValue(column, row_.at(column.slot));
  output_.EndLine();
  std::fill(row_.begin(), row_.end(), kMissing);
  row_begun_ = false;
  ++summary_.rows;
}

TableSummary TableWriter::Close() {
  WriteUpTo(std::numeric_limits<std::int64_t>::max());
  output_.Close();
  return summary_;
}

namespace {

class ExtrasSink final : public MeasurementSink {
 public:
  void OnInfo(const MeasurementInfo&) override {}
  void OnGyro(const GyroSample&) override {}
  void OnAngle(const AngleSample&) override {}
  void OnOrientation(const OrientationSample&) override {}
  void OnTickPair(const TickPair&) override {}
  void OnSegment(const SegmentMark& mark) override { extras_.segments.push_back(mark); }
  void OnDefect(const Defect& defect) override {
    const auto same = std::find_if(extras_.defects.begin(), extras_.defects.end(),
                                   [&](const Defect& d) { return d.kind == defect.kind; });
    if (same == extras_.defects.end()) {
      extras_.defects.push_back(defect);
    } else {
      same->count += defect.count;
    }
  }
  TableExtras Take() { return std::move(extras_); }

 private:
  TableExtras extras_;
};

}  // namespace

TableSummary ExportTable(const fs::path& source, const fs::path& table,
                         const ReplayProgress& progress) {
  const auto half = [&](double done) -> ReplayProgress {
    if (!progress) return {};
    return [&progress, done](double fraction) { progress(done + 0.5 * fraction); };
  };
  ExtrasSink extras;
  Replay(source, extras, half(0.0));
  TableWriter writer(table, extras.Take());
  Replay(source, writer, half(0.5));
  return writer.Close();
}

}  // namespace gyrobench::recording
