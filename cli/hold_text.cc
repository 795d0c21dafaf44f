#include "cli/hold_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <vector>

#include "cli/effect_text.h"
#include "cli/json_field.h"
#include "cli/number_text.h"
#include "cli/vector_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

std::string InputText(const Json& input) {
  return fmt::format("{}: {} samples in {} at {:.1f} Hz, {} rests, {} turns\n", Text(input, "file"),
                     FormatCount(Integer(input, "samples")),
                     FormatDuration(Number(input, "duration_s")), Number(input, "gyro_rate_hz"),
                     Integer(input, "rests"), Integer(input, "turns"));
}

// "held up: +x -x +y -y +z; not: -z"
std::string FacesText(const Json& faces) {
  std::vector<std::string> up, missing;
  for (const Json& face : faces)
    (Field(face, "covered") == true ? up : missing).push_back(Text(face, "up"));
  if (up.empty() && missing.empty()) return "";
  std::string text = fmt::format("  faces held up: {}",
                                 up.empty() ? "none" : fmt::format("{}", fmt::join(up, " ")));
  if (!missing.empty()) text += fmt::format("; not: {}", fmt::join(missing, " "));
  return text + "\n";
}

std::string TurnedText(const std::vector<double>& turned) {
  if (turned.size() != 3) return "";
  return fmt::format(
      "  turned, there and back: {:.0f} deg about x, {:.0f} about y, {:.0f} about z\n", turned[0],
      turned[1], turned[2]);
}

std::string LeftOutText(const Json& left_out, const Terminal& terminal) {
  std::string text;
  for (const Json& left : left_out)
    text += Paragraph(fmt::format("left out: the {} from {:.1f} to {:.1f} s of {}: {}",
                                  Text(left, "what"), Number(left, "begin_s"),
                                  Number(left, "end_s"), Text(left, "file"), Text(left, "because")),
                      terminal, 2);
  return text;
}

std::string BiasText(const Json& result, const Terminal& terminal) {
  const std::vector<double> bias = Numbers(Field(result, "bias_deg_s"));
  const std::vector<double> errors = Numbers(Field(result, "bias_std_error_deg_s"));
  const std::vector<double> units = Numbers(Field(result, "units_per_deg_s"));
  if (bias.size() != 3 || errors.size() != 3 || units.size() != 3) return "";
  const std::string unit = Text(result, "unit");
  Rows rows = {{"", "x", "y", "z", ""}, {"offset b"}};
  for (std::size_t c = 0; c < 3; ++c) rows[1].push_back(FormatMeasured(bias[c], errors[c]));
  rows[1].emplace_back("deg/s");
  if (unit != "deg/s") {
    rows.push_back({"sensitivity s0"});
    for (const double s0 : units) rows.back().push_back(FormatNumber(s0, 6));
    rows.back().push_back(
        fmt::format("{} per deg/s, {}", unit,
                    Field(result, "sensitivity_given") == true ? "as given" : "from these turns"));
  }
  const std::vector<Align> align(5, Align::kLeft);
  return "  gyro, mean over the rests\n" + FitLines(AlignColumns(rows, align, 4), terminal);
}

std::string NoiseText(const Json& result, const Terminal& terminal) {
  const Json& noise = Field(result, "noise");
  const auto row = [](const std::string& name, double value, const std::string& unit,
                      const std::string& note) {
    return std::vector<std::string>{name, FormatNumber(value, 3), unit, note};
  };
  Rows rows = {
      row("turn's end, nominal", Number(result, "angle_rms_nominal_deg"), "deg rms",
          "gravity, against the accelerometer"),
      row("turn's end, calibrated", Number(result, "angle_rms_deg"), "deg rms", ""),
      row("turns, whitened", Number(result, "turn_whitened_rms"), "",
          "each as the others predict it; 1: as the noise explains"),
      row("rests, whitened", Number(result, "accel_whitened_rms"), "", ""),
      row("angle random walk", Number(noise, "angle_random_walk_deg_sqrt_s"), "deg/sqrt(s)",
          "within rests: " + FormatNumber(Number(noise, "rest_angle_random_walk_deg_sqrt_s"), 3)),
      row("bias random walk", Number(noise, "bias_random_walk_deg_s_sqrt_s"), "deg/s/sqrt(s)", ""),
      row("accelerometer", 1e3 * Number(noise, "accel_density_g_sqrt_s"), "mg sqrt(s)",
          "of a rest's mean over the root of its length"),
      row("pose to pose", 1e3 * Number(noise, "pose_scatter_g"), "mg", "beyond that")};
  std::erase_if(rows, [](const auto& cells) { return cells[1] == "-"; });
  return terminal.Bold("Error and noise") + "\n" +
         FitLines(AlignColumns(rows, std::vector<Align>(4, Align::kLeft), 2), terminal);
}

std::string DefectsText(const Json& inputs, const Terminal& terminal) {
  Rows rows;
  for (const Json& input : inputs) {
    for (const Json& defect : Field(input, "defects")) {
      const double first = Number(defect, "first_t_s");
      rows.push_back({Text(defect, "kind"), FormatCount(Integer(defect, "count")),
                      std::isfinite(first) ? fmt::format("first at {:.3f} s", first) : "",
                      Text(defect, "where"), Text(input, "file")});
    }
  }
  if (rows.empty()) return "Defects of the data: none\n";
  return terminal.Bold("Defects of the data") + "\n" +
         AlignColumns(rows, std::vector<Align>(5, Align::kLeft), 2);
}

}  // namespace

std::string HoldText(const Json& result, const Terminal& terminal) {
  std::string text;
  for (const Json& input : Field(result, "inputs")) text += InputText(input);
  text += FacesText(Field(result, "faces"));
  if (!Field(result, "faces").empty()) text += TurnedText(Numbers(Field(result, "turned_deg")));
  text += LeftOutText(Field(result, "left_out"), terminal);
  for (const Json& reason : Field(result, "missing"))
    text += Paragraph("no calibration: " + Plain(reason), terminal, 2);
  if (Field(result, "missing").empty()) {
    text +=
        "\n" + Paragraph(terminal.Bold(Text(result, "verdict")) + ": " + Text(result, "summary"),
                         terminal, 2);
    text += "\n" + BiasText(result, terminal) + VectorText(Field(result, "vector"), terminal);
    text += "\n" + NoiseText(result, terminal);
  }
  text += "\n" + DefectsText(Field(result, "inputs"), terminal);
  const Json& remarks = Field(result, "remarks");
  if (!remarks.empty()) text += "\n" + terminal.Bold("Remarks") + "\n";
  for (const Json& remark : remarks) text += Paragraph(Plain(remark), terminal, 2);
  return text;
}

}  // namespace gyrobench::cli
