#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::AccelerometerCalibration;
using calibration::AxisSplit;
using calibration::GravityCheck;
using calibration::VectorCalibration;

// Rows of three numbers.
class ThreeColumns {
 public:
  explicit ThreeColumns(const std::array<const char*, 3>& heads = {"x", "y", "z"}) {
    table_.columns.emplace_back();
    for (const char* head : heads) table_.columns.push_back({head, kNumber});
    table_.columns.emplace_back();
    table_.splits = true;
  }
  void Add(const std::string& name, const Vector3& values, const Vector3& errors,
           const std::string& unit) {
    if (std::ranges::none_of(values, [](double value) { return std::isfinite(value); })) return;
    std::vector<Text> cells = {name};
    for (std::size_t i = 0; i < 3; ++i)
      cells.push_back(Number(FormatMeasured(values[i], errors[i])));
    cells.push_back(Unit(unit));
    table_.Add(std::move(cells));
  }
  void Add(const std::string& name, const Matrix3& values, const Matrix3& errors,
           const std::string& unit) {
    for (std::size_t i = 0; i < 3; ++i)
      Add(fmt::format("{} {}", name, "xyz"[i]), values[i], errors[i], unit);
  }
  void Add(const AxisSplit& split) { Add("scale factor", split.scale, split.scale_std_error, "1"); }
  const Table& table() const { return table_; }

 private:
  Table table_;
};

void AddNonOrthogonality(Document& document, const Vector3& values_deg, const Vector3& errors_deg) {
  ThreeColumns table({"y-z", "z-x", "x-y"});
  table.Add("non-orthogonality", values_deg, errors_deg, "deg");
  Add(document, table.table());
}

void AddAngles(Document& document, const std::optional<AxisSplit>& split) {
  if (!split) return;
  AddNonOrthogonality(document, split->non_orthogonality_deg,
                      split->non_orthogonality_std_error_deg);
  ThreeColumns mounting({"about x", "about y", "about z"});
  mounting.Add("mounting", split->mount_deg, split->mount_std_error_deg, "deg");
  Add(document, mounting.table());
}

void AddTexts(Document& document, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) Add(document, Paragraph{text, "note"});
}

Section GyroPart(const VectorCalibration& vector) {
  ThreeColumns table;
  if (vector.matrix) {
    table.Add("M", vector.matrix->m, vector.matrix->m_std_error, "1");
    table.Add("A", vector.matrix->a, vector.matrix->a_std_error, "deg/s per " + vector.unit);
    if (vector.split) table.Add(*vector.split);
  }
  Section part{"Gyro: w = A (xi - s0 (b(T) + effects)), row: output, column: axis", {}};
  Add(part.blocks, table.table());
  if (vector.matrix) AddAngles(part.blocks, vector.split);
  return part;
}

Section GravityPart(const VectorCalibration& vector) {
  Section part{"g-sensitivity: row: output, column: gravity along", {}};
  if (!vector.g_sensitivity) return part;
  ThreeColumns table;
  table.Add("offset", vector.g_sensitivity->value, vector.g_sensitivity->std_error, "deg/s/g");
  Add(part.blocks, table.table());
  AddTexts(part.blocks, vector.g_sensitivity->because);
  return part;
}

Section SharedPart(const VectorCalibration& vector) {
  // Channels that agree are found to differ by as much once in a hundred times.
  constexpr double kDiffers = 0.01;
  Table table{{{}, {"", kNumber}, {}, {}, {"", kNote}}, {}};
  for (const calibration::SharedParameter& shared : vector.shared) {
    table.Add({Code(shared.name), Number(FormatMeasured(shared.value, shared.std_error)),
               Unit(shared.unit), "gyro " + shared.channels,
               (shared.p_value < kDiffers ? "differ: " : "agree: ") +
                   Number(FormatPValue(shared.p_value))});
  }
  Section part{"Felt by several channels", {}};
  Add(part.blocks, std::move(table));
  return part;
}

Text CheckText(const GravityCheck& check) {
  // Largest of nine differences: beyond it one time in 240.
  constexpr double kApart = 3.5;
  Text text = "size of gravity in the poses: off 1 g by " +
              Number(FormatNumber(check.rms_before_g, 2)) + " g rms";
  if (std::isfinite(check.rms_after_g))
    text += ", " + Number(FormatNumber(check.rms_after_g, 2)) + " g when corrected";
  if (!std::isfinite(check.largest_difference)) return text;
  return text + fmt::format(
                    "; by that size alone, without the reference, its scale factors, offsets and "
                    "non-orthogonality are the same within {:.1f} standard errors{}",
                    check.largest_difference,
                    check.largest_difference > kApart
                        ? ": reference and accelerometer contradict each other"
                        : "");
}

Section AccelerometerPart(const AccelerometerCalibration& accelerometer) {
  ThreeColumns table;
  table.Add("M", accelerometer.m, accelerometer.m_std_error, "1");
  table.Add("offset", accelerometer.offset_g, accelerometer.offset_std_error_g, "g");
  if (accelerometer.split) table.Add(*accelerometer.split);
  Section part{fmt::format("Accelerometer, {} rests: a = M g + offset", accelerometer.poses), {}};
  Add(part.blocks, table.table());
  AddAngles(part.blocks, accelerometer.split);
  AddTexts(part.blocks, accelerometer.because);
  if (!accelerometer.check) return part;
  const GravityCheck& check = *accelerometer.check;
  if (!accelerometer.split) {  // what the reference did not say, the size of gravity may
    ThreeColumns alone;
    alone.Add("offset", check.offset_g, check.offset_std_error_g, "g");
    alone.Add("scale factor", check.scale, check.scale_std_error, "1");
    Add(part.blocks, Paragraph{"by the size of gravity alone:"});
    Add(part.blocks, alone.table());
    AddNonOrthogonality(part.blocks, check.non_orthogonality_deg,
                        check.non_orthogonality_std_error_deg);
  }
  Add(part.blocks, Paragraph{CheckText(check), "note"});
  return part;
}

}  // namespace

Section VectorSection(const VectorCalibration& vector, const std::string& frame) {
  Section section{"Three axes", {}};
  for (const std::string& reason : vector.missing)
    Add(section.blocks, Paragraph{"no matrix: " + reason, "note"});
  if (vector.matrix) Add(section.blocks, Paragraph{frame, "note"});
  Add(section.blocks, GyroPart(vector));
  Add(section.blocks, GravityPart(vector));
  Add(section.blocks, SharedPart(vector));
  if (vector.accelerometer) Add(section.blocks, AccelerometerPart(*vector.accelerometer));
  AddTexts(section.blocks, vector.remarks);
  return section;
}

}  // namespace gyrobench::presentation
