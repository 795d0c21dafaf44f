#include "cli/bias_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "base/measurement.h"
#include "cli/json_field.h"
#include "cli/noise_text.h"
#include "cli/number_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

std::string OutputUnit(const Json& bias) {
  const std::string unit = Text(bias, "unit");
  return unit.empty() ? "LSB" : unit;
}

// Each remark once, with the axes that it is about where it is not about all.
Json SharedRemarks(const Json& biases) {
  std::vector<std::pair<std::string, std::vector<std::string>>> remarks;
  for (const Json& bias : biases) {
    for (const Json& remark : Field(bias, "remarks")) {
      const std::string text = Plain(remark);
      auto same = std::find_if(remarks.begin(), remarks.end(),
                               [&](const auto& seen) { return seen.first == text; });
      if (same == remarks.end()) same = remarks.insert(same, {text, {}});
      same->second.push_back(Plain(Field(bias, "axis")));
    }
  }
  Json shared = Json::array();
  for (const auto& [text, axes] : remarks) {
    const bool all = axes.size() == biases.size();
    shared.push_back(all ? text : fmt::format("{}: {}", fmt::join(axes, ", "), text));
  }
  return shared;
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
  void AddNumber(const std::string& name, const std::string& unit, const std::string& key) {
    Add(name, unit, [&](const Json& bias) { return FormatNumber(Number(bias, key), 3); });
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

std::string TemperatureRange(const Json& bias) {
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

// As many next to each other as there is room for.
std::string Pictures(const Json& biases, const Terminal& terminal) {
  constexpr int kNarrowest = 32, kWidest = 60;
  const int available = std::min(terminal.columns, 120);
  const int abreast =
      std::clamp(available / kNarrowest, 1, std::max(1, static_cast<int>(biases.size())));
  const int columns = std::clamp(available / abreast - 3, kNarrowest - 3, kWidest);
  std::string text;
  std::vector<std::string> row;
  for (const Json& bias : biases) {
    const std::string picture = Picture(bias, columns);
    if (!picture.empty()) row.push_back(picture);
    if (static_cast<int>(row.size()) == abreast) {
      text += "\n" + SideBySide(row);
      row.clear();
    }
  }
  return row.empty() ? text : text + "\n" + SideBySide(row);
}

std::string TableText(const Json& biases, double duration_s) {
  const std::string output = OutputUnit(biases.front());
  AxisTable table(biases);
  AddCoefficients(table, biases, output);
  table.Add("T_ref", "degC", [](const Json& bias) {
    return FormatNumber(Number(bias, "reference_temperature_degC"), 4);
  });
  table.Add("valid for", "degC", TemperatureRange);
  table.AddNumber("error of the curve", output + " rms", "rms_error");
  table.AddNumber("residual, 1 s means", output + " rms", "residual_rms");
  table.AddNumber("paper's, smoothed", output + " rms", "paper_rms_error");
  const std::array<NoiseLine, 3> noise = NoiseLines(Field(biases.front(), "noise"), duration_s);
  for (std::size_t i = 0; i < 2; ++i) {
    table.Add(noise[i].name, i == 0 ? "deg/sqrt(s)" : "deg/s/sqrt(s)", [&](const Json& bias) {
      return NoiseLines(Field(bias, "noise"), duration_s)[i].value;
    });
  }
  return table.Text();
}

int WidestLine(const std::string& text) {
  int widest = 0;
  for (std::size_t begin = 0, end = text.find('\n'); end != std::string::npos;
       begin = end + 1, end = text.find('\n', begin)) {
    widest = std::max(widest, DisplayWidth(text.substr(begin, end - begin)));
  }
  return widest;
}

// All axes next to each other, or below each other where the terminal is too narrow.
std::string TablesText(const Json& biases, double duration_s, const Terminal& terminal) {
  const std::string together = TableText(biases, duration_s);
  if (!terminal.is_terminal || WidestLine(together) <= terminal.columns) return together;
  std::string text;
  for (const Json& bias : biases) text += TableText(Json::array({bias}), duration_s);
  return text;
}

}  // namespace

std::string BiasText(const Json& biases, double duration_s, bool pictures,
                     const Terminal& terminal) {
  const std::string text = terminal.Bold("Bias: beta(T) = sum of c_j (T - T_ref)^j") + "\n" +
                           TablesText(biases, duration_s, terminal) +
                           RemarksText(SharedRemarks(biases), terminal);
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
