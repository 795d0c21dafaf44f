#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/number.h"
#include "report/sections.h"

namespace gyrobench::report {
namespace {

using calibration::AccelerometerCalibration;
using calibration::AxisSplit;
using calibration::GravityCheck;
using calibration::VectorCalibration;

Markup Cell(double value, double std_error) {
  if (!std::isfinite(value)) return Markup::Text("–");
  return Markup::Text(FormatMeasured(value, std_error, ""));
}

// Rows of three numbers, by group.
class ThreeColumns {
 public:
  explicit ThreeColumns(const std::string& what)
      : table_({{what}, {"x", true}, {"y", true}, {"z", true}, {"Unit"}}, "parameters") {}

  void Group(const std::string& title) { table_.AddGroup(Markup::Text(title)); }
  void Add(const std::string& name, const Vector3& values, const Vector3& errors,
           const std::string& unit) {
    const bool known = std::any_of(values.begin(), values.end(),
                                   [](double value) { return std::isfinite(value); });
    if (!known) return;
    table_.AddRow({Markup::Text(name), Cell(values[0], errors[0]), Cell(values[1], errors[1]),
                   Cell(values[2], errors[2]), Markup::Text(PrintedUnit(unit))});
  }
  void Add(const std::string& name, const Matrix3& values, const Matrix3& errors,
           const std::string& unit) {
    for (std::size_t i = 0; i < 3; ++i)
      Add(fmt::format("{} {}", name, "xyz"[i]), values[i], errors[i], unit);
  }
  void AddSplit(const AxisSplit& split) {
    Add("Scale factor", split.scale, split.scale_std_error, "1");
    Add("Non-orthogonality (y–z, z–x, x–y)", split.non_orthogonality_deg,
        split.non_orthogonality_std_error_deg, "deg");
    Add("Mounting, about", split.mount_deg, split.mount_std_error_deg, "deg");
  }
  Markup ToMarkup() const { return table_.ToMarkup(); }

 private:
  Table table_;
};

Markup Reasons(const std::vector<std::string>& reasons) {
  Markup out;
  for (const std::string& reason : reasons) out += Paragraph(reason + ".", "note");
  return out;
}

Markup GyroTable(const VectorCalibration& vector) {
  ThreeColumns table("Row: output; column: axis");
  if (vector.matrix) {
    table.Group("Matrix M, output over nominal sensitivity per rate");
    table.Add("M", vector.matrix->m, vector.matrix->m_std_error, "1");
    table.Group("Its inverse A, rate per output");
    table.Add("A", vector.matrix->a, vector.matrix->a_std_error, "deg/s per " + vector.unit);
  }
  if (vector.split) {
    table.Group("The same as scale factors, angles between the axes, and mounting");
    table.AddSplit(*vector.split);
  }
  if (vector.g_sensitivity) {
    table.Group("g-sensitivity, offset per gravity along");
    table.Add("Offset", vector.g_sensitivity->value, vector.g_sensitivity->std_error, "deg/s/g");
  }
  Markup out = table.ToMarkup();
  if (vector.g_sensitivity) out += Reasons(vector.g_sensitivity->because);
  return out;
}

Markup SharedTable(const VectorCalibration& vector) {
  if (vector.shared.empty()) return {};
  Table table(
      {{"Felt by several channels"}, {"Channels"}, {"Value", true}, {"Unit"}, {"They agree", true}},
      "parameters");
  for (const auto& shared : vector.shared) {
    table.AddRow({Code(shared.name), Markup::Text(shared.channels),
                  Cell(shared.value, shared.std_error), Markup::Text(PrintedUnit(shared.unit)),
                  Markup::Text(FormatPValue(shared.p_value))});
  }
  return table.ToMarkup();
}

std::string CheckText(const GravityCheck& check) {
  std::string text = fmt::format("In the poses what it feels is {} g (RMS) off the size of 1 g",
                                 FormatNumber(check.rms_before_g, 2));
  if (std::isfinite(check.rms_after_g))
    text += fmt::format(", {} g when corrected", FormatNumber(check.rms_after_g, 2));
  if (std::isfinite(check.largest_difference)) {
    text += fmt::format(
        ". By that size alone, without the reference, its scale factors, offsets and "
        "non-orthogonality come out the same within {:.1f} standard errors",
        check.largest_difference);
  }
  return text + ".";
}

Markup AccelerometerPart(const AccelerometerCalibration& accelerometer) {
  ThreeColumns table("Row: output; column: axis");
  table.Group(fmt::format("Accelerometer = M g + offset, {} rests", accelerometer.poses));
  table.Add("M", accelerometer.m, accelerometer.m_std_error, "1");
  table.Add("Offset", accelerometer.offset_g, accelerometer.offset_std_error_g, "g");
  if (accelerometer.split) {
    table.AddSplit(*accelerometer.split);
  } else if (accelerometer.check) {
    const GravityCheck& check = *accelerometer.check;
    table.Group("By the size of gravity alone");
    table.Add("Offset", check.offset_g, check.offset_std_error_g, "g");
    table.Add("Scale factor", check.scale, check.scale_std_error, "1");
    table.Add("Non-orthogonality (y–z, z–x, x–y)", check.non_orthogonality_deg,
              check.non_orthogonality_std_error_deg, "deg");
  }
  Markup out = table.ToMarkup() + Reasons(accelerometer.because);
  if (accelerometer.check) out += Paragraph(CheckText(*accelerometer.check), "note");
  return out;
}

}  // namespace

Markup VectorSection(const VectorCalibration& vector) {
  Markup inside;
  if (vector.matrix) {
    inside += Paragraph(
        "Rate w = A (output − s0 (b(T) + effects)) in the nominal frame of the sensor: on a stand "
        "that of the inner axis, turned by the configured mounting. Value ± standard error. A "
        "mounting rotation Rz(z) Ry(y) Rx(x) rotates the sensor's vectors into that frame: it is "
        "what is left beyond the configured one. Scale and non-orthogonality do not depend on it.",
        "note");
  }
  for (const std::string& reason : vector.missing)
    inside += Paragraph("No matrix: " + reason + ".", "note");
  if (vector.matrix || vector.g_sensitivity) inside += GyroTable(vector);
  inside += SharedTable(vector);
  if (vector.accelerometer) inside += AccelerometerPart(*vector.accelerometer);
  inside += Reasons(vector.remarks);
  if (inside.empty()) return {};
  return Section("Three axes", inside, "");
}

}  // namespace gyrobench::report
