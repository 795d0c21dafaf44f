#include "cli/bias_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "base/measurement.h"
#include "cli/json_field.h"
#include "cli/number_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

std::string OutputUnit(const Json& bias) {
  const std::string unit = Text(bias, "unit");
  return unit.empty() ? "LSB" : unit;
}

double At(const std::vector<double>& values, std::size_t i) {
  return i < values.size() ? values[i] : kMissing;
}

// A table with an axis a column. Rows without any value are left out.
class AxisTable {
 public:
  explicit AxisTable(const Json& biases) : biases_(biases) {
    std::vector<std::string> head = {""};
    for (const Json& bias : biases) head.push_back(Plain(Field(bias, "axis")));
    rows_.push_back(head);
  }

  void Add(const std::string& name, const std::string& unit,
           const std::function<std::string(const Json&)>& text) {
    std::vector<std::string> row = {name};
    bool any = false;
    for (const Json& bias : biases_) {
      row.push_back(text(bias));
      any = any || row.back() != "-";
    }
    row.push_back(unit);
    if (any) rows_.push_back(row);
  }
  void AddNumber(const std::string& name, const std::string& unit, const std::string& key,
                 const std::string& group = "") {
    Add(name, unit, [&](const Json& bias) {
      return FormatNumber(Number(group.empty() ? bias : Field(bias, group), key), 3);
    });
  }
  std::string Text() const {
    return AlignColumns(rows_, std::vector<Align>(biases_.size() + 2, Align::kLeft), 2);
  }

 private:
  const Json& biases_;
  std::vector<std::vector<std::string>> rows_;
};

void AddCoefficients(AxisTable& table, const Json& biases, const std::string& output) {
  std::size_t count = 0;
  for (const Json& bias : biases) count = std::max(count, Field(bias, "coefficients").size());
  for (std::size_t j = 0; j < count; ++j) {
    const std::string unit = j == 0   ? output
                             : j == 1 ? output + "/degC"
                                      : fmt::format("{}/degC^{}", output, j);
    table.Add(fmt::format("c{}", j), unit, [&](const Json& bias) {
      return FormatMeasured(At(Numbers(Field(bias, "coefficients")), j),
                            At(Numbers(Field(bias, "std_errors")), j));
    });
    table.Add(fmt::format("c{}, the paper's", j), unit, [&](const Json& bias) {
      return FormatNumber(At(Numbers(Field(bias, "paper_coefficients")), j), 5);
    });
  }
}

std::string RangeOf(const Json& bias) {
  const double low = Number(bias, "min_temperature_degC"),
               high = Number(bias, "max_temperature_degC");
  if (!std::isfinite(low) || !std::isfinite(high)) return "-";
  return fmt::format("{:.1f} .. {:.1f}", low, high);
}

std::string Picture(const Json& bias, int columns) {
  const std::vector<double> coefficients = Numbers(Field(bias, "coefficients"));
  const double low = Number(bias, "min_temperature_degC"),
               high = Number(bias, "max_temperature_degC");
  const double reference = Number(bias, "reference_temperature_degC");
  if (coefficients.size() < 2 || !(high > low) || !std::isfinite(reference)) return "";
  Plot plot;
  plot.x_label = "degC";
  plot.y_label = fmt::format("beta {}, {}", Plain(Field(bias, "axis")), OutputUnit(bias));
  plot.x_min = low;
  plot.x_max = high;
  plot.y = [&](double T_degC) {
    double value = 0.0;
    for (std::size_t j = coefficients.size(); j-- > 0;) {
      value = value * (T_degC - reference) + coefficients[j];
    }
    return value;
  };
  plot.columns = columns;
  plot.rows = 8;
  return DrawPlot(plot);
}

std::string Pictures(const Json& biases, const Terminal& terminal) {
  const int side_by_side = (std::min(terminal.columns, 120) - 1) / static_cast<int>(biases.size());
  const int columns = std::clamp(side_by_side - 2, 22, 60);
  std::vector<std::string> pictures;
  for (const Json& bias : biases) {
    const std::string picture = Picture(bias, columns);
    if (!picture.empty()) pictures.push_back(picture);
  }
  if (pictures.empty()) return "";
  const int width = columns * static_cast<int>(pictures.size());
  if (width <= terminal.columns) return "\n" + SideBySide(pictures);
  std::string text;
  for (const std::string& picture : pictures) text += "\n" + picture;
  return text;
}

}  // namespace

std::string BiasText(const Json& biases, bool pictures, const Terminal& terminal) {
  const std::string output = OutputUnit(biases.front());
  AxisTable table(biases);
  AddCoefficients(table, biases, output);
  table.Add("T_ref", "degC", [](const Json& bias) {
    return FormatNumber(Number(bias, "reference_temperature_degC"), 4);
  });
  table.Add("valid for", "degC", RangeOf);
  table.AddNumber("error of the curve", output + ", rms over the range", "rms_error");
  table.AddNumber("residual", output + ", rms of 1 s means", "residual_rms");
  table.AddNumber("the paper's", output + ", rms of the smoothed output", "paper_rms_error");
  table.AddNumber("angle random walk", "deg/sqrt(s)", "angle_random_walk_deg_sqrt_s", "noise");
  table.AddNumber("bias random walk", "deg/s/sqrt(s)", "bias_random_walk_deg_s_sqrt_s", "noise");
  std::string text =
      terminal.Bold("Bias: beta(T) = sum of c_j (T - T_ref)^j") + "\n" + table.Text();
  for (const Json& bias : biases) text += RemarksText(Field(bias, "remarks"), terminal);
  return pictures ? text + Pictures(biases, terminal) : text;
}

std::string RemarksText(const Json& remarks, const Terminal& terminal) {
  std::string text;
  for (const Json& remark : remarks) {
    text += "  - " + Wrap(Plain(remark), terminal.columns - 4, 4) + "\n";
  }
  return text;
}

}  // namespace gyrobench::cli
