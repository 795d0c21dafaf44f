#include "cli/vector_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cli/effect_text.h"
#include "cli/json_field.h"
#include "cli/number_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

std::vector<double> RowOf(const Json& matrix, std::size_t i) {
  return matrix.is_array() && i < matrix.size() ? Numbers(matrix[i]) : std::vector<double>();
}

std::string Cell(const std::vector<double>& values, const std::vector<double>& errors,
                 std::size_t j) {
  if (j >= values.size()) return "-";
  return FormatMeasured(values[j], j < errors.size() ? errors[j] : std::nan(""));
}

// None where nothing of it is known.
void AddRow(Rows& rows, const std::string& name, const std::vector<double>& values,
            const std::vector<double>& errors, const std::string& unit) {
  const bool known =
      std::any_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  if (!known) return;
  rows.push_back(
      {name, Cell(values, errors, 0), Cell(values, errors, 1), Cell(values, errors, 2), unit});
}

void AddVector(Rows& rows, const std::string& name, const Json& part, const std::string& values,
               const std::string& errors, const std::string& unit) {
  AddRow(rows, name, Numbers(Field(part, values)), Numbers(Field(part, errors)), unit);
}

void AddMatrix(Rows& rows, const std::string& name, const Json& part, const std::string& values,
               const std::string& errors, const std::string& unit) {
  for (std::size_t i = 0; i < 3; ++i) {
    AddRow(rows, fmt::format("{} {}", name, "xyz"[i]), RowOf(Field(part, values), i),
           RowOf(Field(part, errors), i), unit);
  }
}

std::string TableText(Rows rows, const std::vector<std::string>& head, const Terminal& terminal) {
  if (rows.empty()) return "";
  rows.insert(rows.begin(), head);
  return FitLines(AlignColumns(rows, std::vector<Align>(5, Align::kLeft), 4), terminal);
}

void AddSplit(Rows& rows, const Json& split) {
  AddVector(rows, "scale factor", split, "scale", "scale_std_error", "1");
}

std::string AnglesText(const Json& split, const Terminal& terminal, const std::string& mounting) {
  if (!split.is_object()) return "";
  Rows across;
  AddVector(across, "non-orthogonality", split, "non_orthogonality_deg",
            "non_orthogonality_std_error_deg", "deg");
  std::string text = TableText(across, {"", "y-z", "z-x", "x-y", ""}, terminal);
  Rows turn;
  AddVector(turn, mounting, split, "mount_deg", "mount_std_error_deg", "deg");
  return text + TableText(turn, {"", "about x", "about y", "about z", ""}, terminal);
}

std::string GyroText(const Json& vector, const Terminal& terminal) {
  const std::vector<std::string> axes = {"", "x", "y", "z", ""};
  std::string text;
  const Json& matrix = Field(vector, "matrix");
  if (matrix.is_object()) {
    Rows rows;
    AddMatrix(rows, "M", matrix, "m", "m_std_error", "1");
    AddMatrix(rows, "A", matrix, "a", "a_std_error", "deg/s per " + Text(vector, "unit"));
    if (Field(vector, "split").is_object()) AddSplit(rows, Field(vector, "split"));
    text += "  gyro: w = A (xi - s0 (b(T) + effects)), row: output, column: axis\n" +
            TableText(rows, axes, terminal) +
            AnglesText(Field(vector, "split"), terminal, "mounting");
  }
  const Json& g = Field(vector, "g_sensitivity");
  if (!g.is_object()) return text;
  Rows rows;
  AddMatrix(rows, "offset", g, "value", "std_error", "deg/s/g");
  text += "  g-sensitivity: row: output, column: gravity along\n" + TableText(rows, axes, terminal);
  for (const Json& reason : Field(g, "because")) text += Paragraph(Plain(reason), terminal, 4);
  return text;
}

std::string CheckText(const Json& check, const Terminal& terminal, bool alone) {
  Rows rows;
  std::string angles;
  if (alone) {
    AddVector(rows, "offset", check, "offset_g", "offset_std_error_g", "g");
    AddSplit(rows, check);
    angles = AnglesText(check, terminal, "");
  }
  const double before = Number(check, "rms_before_g"), after = Number(check, "rms_after_g");
  std::string text =
      fmt::format("size of gravity in the poses: off 1 g by {} g rms", FormatNumber(before, 2));
  if (std::isfinite(after)) text += fmt::format(", {} g when corrected", FormatNumber(after, 2));
  const double apart = Number(check, "largest_difference");
  if (std::isfinite(apart)) {
    constexpr double kApart = 3.5;  // one of nine beyond it: one time in 240
    text += fmt::format(
        "; by that size alone, without the reference, its numbers are the same within {:.1f} "
        "standard errors{}",
        apart, apart > kApart ? ": reference and accelerometer contradict each other" : "");
  }
  return TableText(rows, {"", "x", "y", "z", ""}, terminal) + angles + Paragraph(text, terminal, 4);
}

std::string AccelerometerText(const Json& accelerometer, const Terminal& terminal) {
  if (!accelerometer.is_object()) return "";
  std::string text =
      fmt::format("  accelerometer, {} rests: a = M g + offset\n", Integer(accelerometer, "poses"));
  Rows rows;
  AddMatrix(rows, "M", accelerometer, "m", "m_std_error", "1");
  AddVector(rows, "offset", accelerometer, "offset_g", "offset_std_error_g", "g");
  const Json& split = Field(accelerometer, "split");
  if (split.is_object()) AddSplit(rows, split);
  text +=
      TableText(rows, {"", "x", "y", "z", ""}, terminal) + AnglesText(split, terminal, "mounting");
  for (const Json& reason : Field(accelerometer, "because"))
    text += Paragraph(Plain(reason), terminal, 4);
  // What the reference did not say, the size of gravity may.
  return text + CheckText(Field(accelerometer, "check"), terminal, !split.is_object());
}

// Channels that agree are found to differ by as much once in a hundred times.
constexpr double kDiffers = 0.01;

std::string SharedText(const Json& vector, const Terminal& terminal) {
  const Json& shared = Field(vector, "shared");
  if (shared.empty()) return "";
  Rows rows;
  for (const Json& parameter : shared) {
    rows.push_back({Text(parameter, "name"),
                    FormatMeasured(Number(parameter, "value"), Number(parameter, "std_error")),
                    Text(parameter, "unit"), "gyro " + Text(parameter, "channels"),
                    (Number(parameter, "p_value") < kDiffers ? "differ: " : "agree: ") +
                        PValue(Number(parameter, "p_value"))});
  }
  return "  felt by several channels\n" +
         FitLines(AlignColumns(rows, std::vector<Align>(5, Align::kLeft), 4), terminal);
}

}  // namespace

std::string VectorText(const Json& vector, const Terminal& terminal) {
  if (!vector.is_object()) return "";
  std::string text;
  for (const Json& reason : Field(vector, "missing"))
    text += Paragraph("no matrix: " + Plain(reason), terminal, 2);
  text += GyroText(vector, terminal) + SharedText(vector, terminal) +
          AccelerometerText(Field(vector, "accelerometer"), terminal);
  for (const Json& remark : Field(vector, "remarks")) text += Paragraph(Plain(remark), terminal, 2);
  return text.empty() ? "" : terminal.Bold("Three axes") + "\n" + text;
}

}  // namespace gyrobench::cli
