#include "cli/result_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/measurement.h"
#include "cli/json_field.h"
#include "cli/number_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

std::string AxisOf(const Json& json) { return Plain(Field(json, "axis")); }

// "a .. b unit", or "-" when the range is not known.
std::string RangeText(double low, double high, int decimals, const std::string& unit) {
  if (!std::isfinite(low) || !std::isfinite(high)) return "-";
  return fmt::format("{:.{}f} .. {:.{}f} {}", low, decimals, high, decimals, unit);
}

// Rows of name, value, unit, note; without those that have no value.
class Sheet {
 public:
  void Add(std::string name, std::string value, std::string unit, std::string note = "") {
    if (value == "-" || value.empty()) return;
    rows_.push_back({std::move(name), std::move(value), std::move(unit), std::move(note)});
  }
  std::string Text() const {
    return AlignColumns(rows_, {Align::kLeft, Align::kLeft, Align::kLeft, Align::kLeft}, 2);
  }

 private:
  Rows rows_;
};

void AddNoise(Sheet& sheet, const Json& noise) {
  sheet.Add("angle random walk", FormatNumber(Number(noise, "angle_random_walk_deg_sqrt_s"), 3),
            "deg/sqrt(s)");
  sheet.Add("bias random walk", FormatNumber(Number(noise, "bias_random_walk_deg_s_sqrt_s"), 3),
            "deg/s/sqrt(s)");
  sheet.Add("reference noise", FormatNumber(Number(noise, "reference_deg"), 3), "deg",
            "standard deviation of one reading");
}

std::string Remarks(const Json& remarks, const Terminal& terminal) {
  std::string text;
  for (const Json& remark : remarks) {
    text += "  - " + Wrap(Plain(remark), terminal.columns - 4, 4) + "\n";
  }
  return text;
}

std::string ScaleHeading(const Json& scale) {
  std::string text = fmt::format("Scale factor, gyro {}", AxisOf(scale));
  const std::int64_t turns = Integer(scale, "turns");
  if (turns > 0) text += fmt::format(": {} turn{}", FormatCount(turns), turns == 1 ? "" : "s");
  const std::string schedule = Text(scale, "schedule");
  if (schedule == "stops") text += ", from stop to stop";
  if (schedule == "continuous") text += ", followed continuously";
  return text;
}

std::string ScaleText(const Json& scale, const Terminal& terminal) {
  const std::string output = Text(scale, "unit").empty() ? "LSB" : Text(scale, "unit");
  const std::string unit = "deg/s per " + output;
  const double alpha = Number(scale, "alpha"), alpha_error = Number(scale, "alpha_std_error");
  const double scale_error = Number(scale, "scale_error");
  const double temperature = Number(scale, "bias_temperature_degC");
  Sheet sheet;
  sheet.Add("alpha, joint estimate", FormatMeasured(alpha, alpha_error), unit);
  sheet.Add("alpha, eq. (5)",
            FormatMeasured(Number(scale, "paper_alpha"), Number(scale, "paper_alpha_std_error")),
            unit, "the paper's: each turn with the rest before it");
  sheet.Add("alpha, eq. (5)", FormatNumber(Number(scale, "paper_first_rest_alpha")), unit,
            "the same with the first rest only");
  sheet.Add("scale error",
            FormatMeasured(100.0 * scale_error, 100.0 * (1.0 + scale_error) * alpha_error / alpha),
            "%", "against the nominal sensitivity");
  sheet.Add("bias", FormatMeasured(Number(scale, "bias"), Number(scale, "bias_std_error")), output,
            std::isfinite(temperature) ? fmt::format("at {:.2f} degC", temperature) : "");
  const double whitened = Number(scale, "whitened_rms");
  sheet.Add("residual, rms", FormatNumber(Number(scale, "residual_rms_deg"), 3), "deg",
            std::isfinite(whitened)
                ? fmt::format("whitened {:.2f}; 1 when the model explains it", whitened)
                : "");
  AddNoise(sheet, Field(scale, "noise"));
  sheet.Add("unit's clock",
            FormatMeasured(Number(scale, "tick_ratio"), Number(scale, "tick_ratio_std_error")),
            "s/s", "host seconds per second of the gyro unit");
  sheet.Add("valid for",
            RangeText(Number(scale, "min_rate_deg_s"), Number(scale, "max_rate_deg_s"), 1, "deg/s"),
            "");
  sheet.Add("",
            RangeText(Number(scale, "min_temperature_degC"), Number(scale, "max_temperature_degC"),
                      1, "degC"),
            "");
  return terminal.Bold(ScaleHeading(scale)) + "\n" + sheet.Text() +
         Remarks(Field(scale, "remarks"), terminal);
}

std::vector<double> Numbers(const Json& list) {
  std::vector<double> numbers;
  for (const Json& value : list)
    numbers.push_back(value.is_number() ? value.get<double>() : kMissing);
  return numbers;
}

double Polynomial(const std::vector<double>& coefficients, double x) {
  double value = 0.0;
  for (auto c = coefficients.rbegin(); c != coefficients.rend(); ++c) value = value * x + *c;
  return value;
}

std::string BiasPicture(const Json& bias, const std::string& output, const Terminal& terminal) {
  const std::vector<double> coefficients = Numbers(Field(bias, "coefficients"));
  const double low = Number(bias, "min_temperature_degC"),
               high = Number(bias, "max_temperature_degC");
  const double reference = Number(bias, "reference_temperature_degC");
  if (coefficients.size() < 2 || !(high > low) || !std::isfinite(reference)) return "";
  Plot plot;
  plot.x_label = "T, degC";
  plot.y_label = "beta(T), " + output;
  plot.x_min = low;
  plot.x_max = high;
  plot.y = [&](double T_degC) { return Polynomial(coefficients, T_degC - reference); };
  plot.columns = std::min(72, terminal.columns - 1);
  return "\n" + DrawPlot(plot);
}

std::string Power(std::size_t j) { return j < 2 ? "" : fmt::format("^{}", j); }

void AddCoefficients(Sheet& sheet, const Json& bias, const std::string& output) {
  const std::vector<double> values = Numbers(Field(bias, "coefficients"));
  const std::vector<double> errors = Numbers(Field(bias, "std_errors"));
  const std::vector<double> paper = Numbers(Field(bias, "paper_coefficients"));
  for (std::size_t j = 0; j < std::max(values.size(), paper.size()); ++j) {
    const std::string unit = j == 0 ? output : fmt::format("{}/degC{}", output, Power(j));
    const std::string value =
        j < values.size() ? FormatMeasured(values[j], j < errors.size() ? errors[j] : kMissing)
                          : "0";
    sheet.Add(fmt::format("c{}", j), value, unit,
              j < paper.size() ? "paper " + FormatNumber(paper[j], 5) : "");
  }
}

std::string BiasText(const Json& bias, const Terminal& terminal) {
  const std::string output = Text(bias, "unit").empty() ? "LSB" : Text(bias, "unit");
  const double reference = Number(bias, "reference_temperature_degC");
  std::string heading = fmt::format("Bias, gyro {}", AxisOf(bias));
  if (std::isfinite(reference)) {
    heading += fmt::format(": beta(T) = sum of c_j (T - {:.2f} degC)^j", reference);
  }
  Sheet sheet;
  AddCoefficients(sheet, bias, output);
  const std::string range = RangeText(Number(bias, "min_temperature_degC"),
                                      Number(bias, "max_temperature_degC"), 1, "degC");
  sheet.Add("error of the curve", FormatNumber(Number(bias, "rms_error"), 3), output,
            range == "-" ? "rms" : "rms over " + range);
  sheet.Add("", FormatNumber(Number(bias, "paper_rms_error"), 3), output,
            "the paper's: smoothed output about its curve");
  sheet.Add("residual, rms", FormatNumber(Number(bias, "residual_rms"), 3), output,
            "1 s means about the curve");
  AddNoise(sheet, Field(bias, "noise"));
  return terminal.Bold(heading) + "\n" + sheet.Text() + Remarks(Field(bias, "remarks"), terminal) +
         BiasPicture(bias, output, terminal);
}

std::string DefectText(const Json& defects, const Terminal& terminal) {
  if (!defects.is_array() || defects.empty()) return "Defects of the data: none\n";
  Rows rows;
  for (const Json& defect : defects) {
    const double first = Number(defect, "first_t_s");
    rows.push_back({Text(defect, "kind"), FormatCount(Integer(defect, "count")),
                    std::isfinite(first) ? fmt::format("first at {:.3f} s", first) : "",
                    Text(defect, "where")});
  }
  return terminal.Bold("Defects of the data") + "\n" +
         AlignColumns(rows, {Align::kLeft, Align::kRight, Align::kLeft, Align::kLeft}, 2);
}

std::string SourceText(const Json& result) {
  const Json& info = Field(result, "info");
  std::string source = Text(info.is_null() ? result : info, "source");
  if (source.empty()) source = Text(result, "source");
  std::vector<std::string> facts;
  const std::int64_t samples = Integer(result, "samples");
  if (samples > 0) facts.push_back(FormatCount(samples) + " samples");
  const double duration = Number(result, "duration_s");
  if (std::isfinite(duration)) facts.push_back("in " + FormatDuration(duration));
  const double rate = Number(result, "gyro_rate_hz");
  if (std::isfinite(rate)) facts.push_back(fmt::format("at {:.1f} Hz", rate));
  std::string text = fmt::format("{}", fmt::join(facts, " "));
  const std::int64_t reference = Integer(result, "reference_samples");
  if (reference > 0) text += fmt::format(", {} of the reference", FormatCount(reference));
  if (source.empty()) return text;
  return text.empty() ? source : source + ": " + text;
}

}  // namespace

std::string ResultText(const Json& result, const Terminal& terminal) {
  std::string text = SourceText(result) + "\n";
  for (const Json& scale : Field(result, "scale")) text += "\n" + ScaleText(scale, terminal);
  for (const Json& bias : Field(result, "bias")) text += "\n" + BiasText(bias, terminal);
  text += "\n" + DefectText(Field(result, "defects"), terminal);
  const std::string remarks = Remarks(Field(result, "remarks"), terminal);
  if (!remarks.empty()) text += "\n" + terminal.Bold("Remarks") + "\n" + remarks;
  return text;
}

std::string ResultSummary(const Json& result) {
  std::vector<std::string> parts;
  for (const Json& scale : Field(result, "scale")) {
    parts.push_back(
        fmt::format("alpha {} {} deg/s per {}", AxisOf(scale),
                    FormatMeasured(Number(scale, "alpha"), Number(scale, "alpha_std_error")),
                    Text(scale, "unit")));
  }
  if (parts.empty()) {
    for (const Json& bias : Field(result, "bias")) {
      const std::vector<double> values = Numbers(Field(bias, "coefficients"));
      const std::vector<double> errors = Numbers(Field(bias, "std_errors"));
      if (values.empty()) continue;
      parts.push_back(fmt::format("bias {} {} {}", AxisOf(bias),
                                  FormatMeasured(values[0], errors.empty() ? kMissing : errors[0]),
                                  Text(bias, "unit")));
    }
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace gyrobench::cli
