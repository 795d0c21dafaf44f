#include "recording/table_columns.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <sstream>

#include "base/error.h"
#include "base/geometry.h"
#include "recording/plausible.h"
#include "recording/table_words.h"

namespace gyrobench::recording {

namespace {

// What a person can read of bytes that should have been text.
std::string Shown(std::string_view text) {
  constexpr std::size_t kShown = 60;
  std::string shown;
  for (const char c : text.substr(0, kShown)) {
    shown += c >= ' ' && c < 127 ? std::string(1, c)
                                 : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
  }
  return text.size() > kShown ? shown + "..." : shown;
}

struct Known {
  const char* name;
  ColumnKind kind;
  int index;
};

constexpr Known kWholeNames[] = {
    {"t_s", ColumnKind::kTime, 0},
    {"temp_degC", ColumnKind::kTemperature, 0},
    {"ref_outer_deg", ColumnKind::kStandAngle, 0},
    {"ref_middle_deg", ColumnKind::kStandAngle, 1},
    {"ref_inner_deg", ColumnKind::kStandAngle, 2},
    {"ref_angle_x_deg", ColumnKind::kSensorAngle, 0},
    {"ref_angle_y_deg", ColumnKind::kSensorAngle, 1},
    {"ref_angle_z_deg", ColumnKind::kSensorAngle, 2},
    {"ref_qw", ColumnKind::kQuaternion, 0},
    {"ref_qx", ColumnKind::kQuaternion, 1},
    {"ref_qy", ColumnKind::kQuaternion, 2},
    {"ref_qz", ColumnKind::kQuaternion, 3},
    {"unit_tick_s", ColumnKind::kUnitTick, 0},
};

// Units of an angle that are not read.
constexpr std::string_view kOtherAngles[] = {"rad", "mrad",   "turn",  "turns",
                                             "rev", "arcmin", "arcsec"};

// The unit at the end of gyro_x_<unit>, accel_x_<unit>.
std::string UnitOf(const TableColumn& column) {
  const std::size_t stem = column.kind == ColumnKind::kGyro ? 7 : 8;
  return column.name.substr(stem);
}

// gyro_x_lsb: true and the axis when `name` is <stem><x|y|z>_<one of the units>.
bool IsAxisColumn(std::string_view name, std::string_view stem,
                  std::initializer_list<std::string_view> units, int& axis) {
  if (!name.starts_with(stem) || name.size() < stem.size() + 2) return false;
  const char letter = name[stem.size()];
  if (letter < 'x' || letter > 'z' || name[stem.size() + 1] != '_') return false;
  axis = letter - 'x';
  return std::find(units.begin(), units.end(), name.substr(stem.size() + 2)) != units.end();
}

TableColumn Interpret(std::string_view name) {
  TableColumn column{std::string(name)};
  for (const Known& known : kWholeNames) {
    if (name == known.name) return {column.name, known.kind, known.index};
  }
  if (IsAxisColumn(name, "gyro_", {"lsb", "deg_s", "rad_s"}, column.index)) {
    column.kind = ColumnKind::kGyro;
  } else if (IsAxisColumn(name, "accel_", {"lsb", "g", "m_s2"}, column.index)) {
    column.kind = ColumnKind::kAccel;
  }
  return column;
}

// Each is compared with all names that might be meant.
constexpr std::size_t kMostNotes = 1000;

// Of columns without a time, what to do about it where that is plain.
std::string WhatWasMeant(const std::vector<std::string>& names) {
  if (names.size() == 1) {
    for (const char* separator : {";", "\t", " "}) {
      if (names[0].find(separator) == std::string::npos) continue;
      return fmt::format(
          "; its columns are separated by {}: put commas there, and points into the numbers",
          *separator == '\t' ? "tabs" : fmt::format("'{}'", separator));
    }
  }
  const auto time = std::ranges::find_if(names, MeansTime);
  return time == names.end()
             ? ""
             : fmt::format("; is '{}' meant? Rename it to t_s, in seconds", Shown(*time));
}

}  // namespace

void TableHead::Fail(std::int64_t line_number, const std::string& what) const {
  throw DataError(fmt::format("{}:{}: {}", file_, line_number, what));
}

double TableHead::Number(const std::string& key, const std::string& value, double min, double max,
                         std::int64_t line_number) const {
  double number = kMissing;
  const char* end = value.data() + value.size();
  const auto [stop, error] = std::from_chars(value.data(), end, number);
  if (error != std::errc() || stop != end || !(number >= min && number <= max)) {
    Fail(line_number,
         fmt::format("{} = {}: expected a number {} .. {}", key, Shown(value), min, max));
  }
  return number;
}

void TableHead::Comment(std::string_view line, std::int64_t line_number) {
  line.remove_prefix(1);
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return;
  const std::string key(Trim(line.substr(0, equals)));
  const std::string value(Trim(line.substr(equals + 1)));
  if (!key.empty()) Key(key, value, line_number);
}

void TableHead::Key(const std::string& key, const std::string& value, std::int64_t line_number) {
  if (key == "segment") return Segment(value, line_number);
  if (key == "defect") return RecordedDefect(value, line_number);
  if (info_.key_lines.contains(key))
    Fail(line_number, fmt::format("{} is given twice; keep one of them", Shown(key)));
  info_.key_lines[key] = line_number;
  const auto number = [&](double min, double max) {
    return Number(key, value, min, max, line_number);
  };
  for (const auto& [name, value_deg, limit_deg] : AnglesOf(info_.geometry)) {
    if (key != name) continue;
    *value_deg = number(-limit_deg, limit_deg);
    return;
  }
  if (key == "gyro_lsb_zero") {
    info_.gyro_lsb_zero = number(0.0, kLargestZero);
  } else if (key == "accel_lsb_zero") {
    info_.accel_lsb_zero = number(0.0, kLargestZero);
  } else if (key == "ref_scale_uncertainty") {
    info_.reference_uncertainty.scale = number(0.0, kLargestScaleUncertainty);
  } else if (key == "ref_eccentricity_deg") {
    info_.reference_uncertainty.eccentricity_deg = number(0.0, kLargestBound_deg);
  } else if (key == "ref_alignment_deg") {
    info_.reference_uncertainty.alignment_deg = number(0.0, kLargestBound_deg);
  } else if (key == "site_latitude_deg") {
    info_.site_latitude_deg = number(-90.0, 90.0);
  } else if (key == "site_heading_deg") {
    info_.site_heading_deg = number(-360.0, 360.0);
  } else if (key == "gyro_lsb_per_deg_s") {
    gyro_lsb_per_deg_s_ = number(kSmallestFactor, kLargestFactor);
  } else if (key == "accel_lsb_per_g") {
    accel_lsb_per_g_ = number(kSmallestFactor, kLargestFactor);
  } else if (key == "gear_ratio") {
    info_.gear_ratio = number(kSmallestFactor, kLargestFactor);
  } else if (key == "stop_accuracy_deg") {
    info_.stop_accuracy_deg = number(kSmallestFactor, kLargestFactor);
  } else if (key == "gyro_delay_s") {
    info_.gyro_delay_s = number(0.0, kLongestDelay_s);
  } else if (key == "ref_delay_s") {
    info_.reference_delay_s = number(0.0, kLongestDelay_s);
  } else if (key == "sensor") {
    info_.sensor = value;
  } else if (key == "power_on") {
    info_.power_on = value;
  } else {
    if (const std::string near = NearestKey(key); !near.empty()) {
      Fail(line_number,
           fmt::format("unknown key {}: did you mean {}? Rename it; a key that is none of the "
                       "table's own needs another name",
                       Shown(key), near));
    }
    if (info_.notes.size() >= kMostNotes) {
      Fail(line_number,
           fmt::format("more than {} comments of the form key = value that are none of "
                       "the table's own: leave them out",
                       kMostNotes));
    }
    info_.notes.emplace(key, value);
  }
}

// begin_s end_s kind name, as TableWriter writes it.
void TableHead::Segment(const std::string& value, std::int64_t line_number) {
  std::istringstream in(value);
  SegmentMark mark;
  if (!(in >> mark.begin_s >> mark.end_s >> mark.kind) || !(mark.begin_s >= -kLatestTime_s) ||
      !(mark.end_s >= mark.begin_s) || !(mark.end_s <= kLatestTime_s)) {
    Fail(line_number, fmt::format("segment = {}: expected begin_s end_s kind name", Shown(value)));
  }
  std::getline(in >> std::ws, mark.name);
  segments_.push_back(std::move(mark));
}

// kind count first_t_s where, as TableWriter writes it.
void TableHead::RecordedDefect(const std::string& value, std::int64_t line_number) {
  std::istringstream in(value);
  Defect defect;
  std::string first_t_s;
  if (!(in >> defect.kind >> defect.count >> first_t_s) || defect.count < 0 ||
      defect.count > kMostSamples) {
    Fail(line_number,
         fmt::format("defect = {}: expected kind count first_t_s where", Shown(value)));
  }
  if (first_t_s != "nan") {
    defect.first_t_s =
        Number("defect's first_t_s", first_t_s, -kLatestTime_s, kLatestTime_s, line_number);
  }
  std::getline(in >> std::ws, defect.where);
  defects_.push_back(std::move(defect));
}

void TableHead::Header(std::string_view line, std::int64_t line_number) {
  info_.first_row_line = line_number + 1;
  if (line.find('\0') != std::string_view::npos) {
    Fail(line_number, fmt::format("no measurement table: expected a header line with t_s, found "
                                  "binary data '{}'",
                                  Shown(line)));
  }
  while (true) {
    const std::size_t comma = line.find(',');
    columns_.push_back(Interpret(Unquote(line.substr(0, comma))));
    if (columns_.size() > kMaxTableColumns) {
      Fail(line_number, fmt::format("more than {} columns", kMaxTableColumns));
    }
    if (comma == std::string_view::npos) break;
    line.remove_prefix(comma + 1);
  }
  CheckColumns(line_number);
  CheckUnits(ColumnKind::kGyro, line_number);
  CheckUnits(ColumnKind::kAccel, line_number);
  FillInfo(line_number);
  CheckReference(line_number);
}

void TableHead::CheckColumns(std::int64_t line_number) {
  std::vector<std::string> names;
  for (const TableColumn& column : columns_) names.push_back(column.name);
  const auto time = std::find(names.begin(), names.end(), "t_s");
  if (time == names.end()) {
    std::string found;
    for (const std::string& name : names) found += (found.empty() ? "" : ",") + name;
    Fail(line_number,
         fmt::format("no measurement table: expected a header line with the column t_s "
                     "(time in seconds), found '{}'{}",
                     Shown(found), WhatWasMeant(names)));
  }
  time_column_ = static_cast<std::size_t>(time - names.begin());
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice != names.end()) {
    Fail(line_number, twice->empty() ? std::string("two columns have no name; name or remove them")
                                     : fmt::format("column {} is there twice; rename or remove one",
                                                   Shown(*twice)));
  }
  if (Names(ColumnKind::kGyro).empty()) {
    constexpr std::size_t kMost = 12;  // of the others
    std::string near, all;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const std::string& name = names[i];
      if (i < kMost) all += (all.empty() ? "" : ", ") + Shown(name);
      if (i == kMost) all += " ...";
      if (name.starts_with("gyro")) near += (near.empty() ? "" : ", ") + Shown(name);
    }
    Fail(
        line_number,
        fmt::format("no column of the gyro: expected at least one of gyro_x_lsb, gyro_y_lsb, "
                    "gyro_z_lsb (or with _deg_s, _rad_s), found {}: rename it, or convert its unit",
                    near.empty() ? all : near));
  }
  CheckReferenceUnits(line_number);
  CheckNearNames(line_number);
}

// A name that was meant to be one of the table's would pass for a covariate.
void TableHead::CheckNearNames(std::int64_t line_number) const {
  for (const TableColumn& column : columns_) {
    if (column.kind != ColumnKind::kCovariate || column.IsInCounts()) continue;
    const std::string near = NearestColumn(column.name);
    if (near.empty()) continue;
    Fail(line_number, fmt::format("column {}: did you mean {}? Rename it, and convert its values "
                                  "where the unit is another one; a further quantity needs a name "
                                  "that says what it is, such as supply_v",
                                  Shown(column.name), near));
  }
}

// An angle of the reference in another unit would pass for a covariate, and the sensor for resting.
void TableHead::CheckReferenceUnits(std::int64_t line_number) const {
  for (const TableColumn& column : columns_) {
    for (const Known& known : kWholeNames) {
      const std::string_view name = known.name;
      const bool is_angle =
          known.kind == ColumnKind::kStandAngle || known.kind == ColumnKind::kSensorAngle;
      const std::string_view stem = name.substr(0, name.size() - 3);  // "ref_inner_"
      if (!is_angle || !column.name.starts_with(stem) || column.name == name) continue;
      const std::string unit = column.name.substr(stem.size());
      if (std::find(std::begin(kOtherAngles), std::end(kOtherAngles), unit) ==
          std::end(kOtherAngles))
        continue;
      Fail(line_number, fmt::format("column {}: expected {}, found the unit {}; convert it to "
                                    "degrees and rename it",
                                    column.name, name, unit));
    }
  }
}

std::string TableHead::Names(ColumnKind kind) const {
  std::string names;
  for (const TableColumn& column : columns_) {
    if (column.kind == kind) names += (names.empty() ? "" : ", ") + column.name;
  }
  return names;
}

void TableHead::CheckUnits(ColumnKind kind, std::int64_t line_number) const {
  std::string unit;
  for (const TableColumn& column : columns_) {
    if (column.kind != kind) continue;
    if (!unit.empty() && UnitOf(column) != unit) {
      Fail(line_number,
           fmt::format("columns {} mix units: expected one unit for all three axes", Names(kind)));
    }
    unit = UnitOf(column);
  }
}

void TableHead::CheckReference(std::int64_t line_number) {
  constexpr ColumnKind kKinds[] = {ColumnKind::kStandAngle, ColumnKind::kSensorAngle,
                                   ColumnKind::kQuaternion};
  constexpr ReferenceKind kReferences[] = {ReferenceKind::kStandAngles, ReferenceKind::kSensorAngle,
                                           ReferenceKind::kOrientation};
  std::string found;
  for (std::size_t i = 0; i < std::size(kKinds); ++i) {
    const std::string names = Names(kKinds[i]);
    if (names.empty()) continue;
    if (!found.empty()) {
      Fail(line_number,
           fmt::format("two kinds of reference: {} and {}; keep one of them", found, names));
    }
    found = names;
    info_.reference = kReferences[i];
  }
  const auto commas = std::count(found.begin(), found.end(), ',');
  if (info_.reference == ReferenceKind::kOrientation && commas != 3) {
    Fail(
        line_number,
        fmt::format("reference orientation needs ref_qw, ref_qx, ref_qy, ref_qz; found {}", found));
  }
  if (info_.reference == ReferenceKind::kSensorAngle && commas != 0) {
    Fail(line_number,
         fmt::format("expected one reference angle about an axis of the sensor, found {}", found));
  }
}

void TableHead::FillInfo(std::int64_t line_number) {
  info_.source = file_;
  for (TableColumn& column : columns_) {
    const auto axis = static_cast<std::size_t>(column.index);
    if (column.kind == ColumnKind::kGyro && column.IsInCounts())
      column.zero = info_.gyro_lsb_zero.value_or(0.0);
    if (column.kind == ColumnKind::kAccel) ScaleAccel(column);
    switch (column.kind) {
      case ColumnKind::kGyro:
        info_.gyro_present.at(axis) = true;
        break;
      case ColumnKind::kAccel:
        info_.accel_present.at(axis) = true;
        break;
      case ColumnKind::kTemperature:
        info_.temperature_present = true;
        break;
      case ColumnKind::kStandAngle:
        info_.stand_axis_present.at(axis) = true;
        break;
      case ColumnKind::kSensorAngle:
        info_.reference_axis = static_cast<SensorAxis>(column.index);
        break;
      case ColumnKind::kCovariate:
        if (column.name.empty()) Fail(line_number, "a column has no name; name or remove it");
        info_.covariates.push_back(column.name);
        break;
      case ColumnKind::kTime:
      case ColumnKind::kQuaternion:
      case ColumnKind::kUnitTick:
        break;
    }
  }
  FillGyroUnit();
}

// Accelerometer counts without their sensitivity cannot become g: they stay a covariate, unscaled.
void TableHead::ScaleAccel(TableColumn& column) const {
  const std::string unit = UnitOf(column);
  if (unit == "m_s2") column.scale = 1.0 / kStandardGravity_m_s2;
  if (unit != "lsb") return;
  if (std::isnan(accel_lsb_per_g_)) {
    column.kind = ColumnKind::kCovariate;
  } else {
    column.zero = info_.accel_lsb_zero.value_or(0.0);
    column.scale = 1.0 / accel_lsb_per_g_;
  }
}

void TableHead::FillGyroUnit() {
  const auto gyro = std::find_if(columns_.begin(), columns_.end(), [](const TableColumn& column) {
    return column.kind == ColumnKind::kGyro;
  });
  const std::string unit = UnitOf(*gyro);
  if (unit == "deg_s") {
    info_.gyro_unit = RateUnit::kDegPerSecond;
    info_.gyro_units_per_deg_s = 1.0;
  } else if (unit == "rad_s") {
    info_.gyro_unit = RateUnit::kRadPerSecond;
    info_.gyro_units_per_deg_s = kRadPerDeg;
  } else if (!std::isnan(gyro_lsb_per_deg_s_)) {
    info_.gyro_units_per_deg_s = gyro_lsb_per_deg_s_;
  }
}

}  // namespace gyrobench::recording
