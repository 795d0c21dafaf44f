#include "cli/result_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "base/measurement.h"
#include "calibration/effects/effect.h"
#include "cli/bias_text.h"
#include "cli/json_field.h"
#include "cli/noise_text.h"
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

// Rows of name, value, unit, note; without those that have no value, and without notes where the
// terminal has no room.
class Sheet {
 public:
  void Add(std::string name, std::string value, std::string unit, std::string note = "") {
    if (value == "-" || value.empty()) return;
    rows_.push_back({std::move(name), std::move(value), std::move(unit)});
    notes_.push_back(std::move(note));
  }
  std::string Text(const Terminal& terminal) const {
    Rows rows = rows_;
    int width = 2;
    for (std::size_t column = 0; column < 3; ++column) {
      int widest = 0;
      for (const auto& row : rows) widest = std::max(widest, DisplayWidth(row[column]));
      width += widest + 2;
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const bool fits =
          !terminal.is_terminal || width + DisplayWidth(notes_[i]) <= terminal.columns;
      if (fits) rows[i].push_back(notes_[i]);
    }
    return AlignColumns(rows, {Align::kLeft, Align::kLeft, Align::kLeft, Align::kLeft}, 2);
  }

 private:
  Rows rows_;
  std::vector<std::string> notes_;
};

void AddNoise(Sheet& sheet, const Json& noise, double duration_s) {
  for (const NoiseLine& line : NoiseLines(noise, duration_s)) {
    const bool reading = line.note.empty() && line.name == "reference noise";
    sheet.Add(line.name, line.value, line.unit,
              reading ? "standard deviation of one reading" : line.note);
  }
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

std::string ScaleText(const Json& scale, double duration_s, const Terminal& terminal) {
  const std::string output = Text(scale, "unit").empty() ? "LSB" : Text(scale, "unit");
  const std::string unit = "deg/s per " + output;
  const double alpha = Number(scale, "alpha"), alpha_error = Number(scale, "alpha_std_error");
  const double scale_error = Number(scale, "scale_error");
  const double temperature = Number(scale, "bias_temperature_degC");
  Sheet sheet;
  sheet.Add("alpha, joint estimate", FormatMeasured(alpha, alpha_error), unit);
  const double reference = Number(scale, "reference_uncertainty");
  if (std::isfinite(reference)) {
    sheet.Add("  of the fit alone",
              "± " + FormatNumber(Number(scale, "alpha_statistical_std_error"), 2), unit,
              fmt::format("the reference adds {:.2g} of alpha", reference));
  }
  sheet.Add("alpha, eq. (5)",
            FormatMeasured(Number(scale, "paper_alpha"), Number(scale, "paper_alpha_std_error")),
            unit, "the paper's: rest before each turn");
  sheet.Add("alpha, eq. (5) once", FormatNumber(Number(scale, "paper_first_rest_alpha")), unit,
            "the paper's: first rest only");
  sheet.Add("scale error",
            FormatMeasured(100.0 * scale_error, 100.0 * (1.0 + scale_error) * alpha_error / alpha),
            "%", "against the nominal sensitivity");
  sheet.Add("bias", FormatMeasured(Number(scale, "bias"), Number(scale, "bias_std_error")), output,
            std::isfinite(temperature) ? fmt::format("at {:.2f} degC", temperature) : "");
  const double whitened = Number(scale, "whitened_rms");
  sheet.Add("residual, rms", FormatNumber(Number(scale, "residual_rms_deg"), 3), "deg",
            std::isfinite(whitened)
                ? fmt::format("whitened {:.2f}; 1: as the noise explains", whitened)
                : "");
  AddNoise(sheet, Field(scale, "noise"), duration_s);
  sheet.Add("unit's clock",
            FormatMeasured(Number(scale, "tick_ratio"), Number(scale, "tick_ratio_std_error")),
            "s/s", "host over gyro unit");
  sheet.Add("valid for",
            RangeText(Number(scale, "min_rate_deg_s"), Number(scale, "max_rate_deg_s"), 1, "deg/s"),
            "", "mean rate of each turn, from rest to rest");
  sheet.Add("",
            RangeText(Number(scale, "min_temperature_degC"), Number(scale, "max_temperature_degC"),
                      1, "degC"),
            "");
  return terminal.Bold(ScaleHeading(scale)) + "\n" + sheet.Text(terminal) +
         RemarksText(Field(scale, "remarks"), terminal);
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
  if (duration > 0.0) facts.push_back("in " + FormatDuration(duration));
  const double rate = Number(result, "gyro_rate_hz");
  if (std::isfinite(rate)) facts.push_back(fmt::format("at {:.1f} Hz (median interval)", rate));
  std::string text = fmt::format("{}", fmt::join(facts, " "));
  const std::int64_t reference = Integer(result, "reference_samples");
  if (reference > 0) text += fmt::format(", {} of the reference", FormatCount(reference));
  if (source.empty()) return text;
  return text.empty() ? source : source + ": " + text;
}

// The channel's effects that are so, each once: "scale.cubic, scale.g".
std::string NamedEffects(const Json& channel, bool (*is_so)(const std::string& id)) {
  std::vector<std::string> ids;
  for (const Json& effect : Field(channel, "effects")) {
    const std::string id = Text(effect, "id");
    if (is_so(id) && std::ranges::find(ids, id) == ids.end()) ids.push_back(id);
  }
  return fmt::format("{}", fmt::join(ids, ", "));
}

bool IsOfScale(const std::string& id) { return id.starts_with("scale."); }

bool IsBiasByGravity(const std::string& id) {
  const calibration::Effect* effect = calibration::FindEffect(id);
  return effect != nullptr && effect->needs == calibration::kNeedsGravity && !effect->true_motion;
}

// To the remarks of the entry of list `key` that is of gyro axis `axis`.
void AddRemark(Json& result, const char* key, const std::string& axis, const std::string& remark) {
  if (!Field(result, key).is_array()) return;
  for (Json& entry : result[key]) {
    if (AxisOf(entry) != axis) continue;
    if (!entry["remarks"].is_array()) entry["remarks"] = Json::array();
    entry["remarks"].push_back(remark);
  }
}

}  // namespace

std::string ResultText(const Json& result, const Terminal& terminal) {
  std::string text = SourceText(result);
  if (!text.empty()) text += "\n";
  const double duration_s = Number(result, "duration_s");
  for (const Json& scale : Field(result, "scale"))
    text += "\n" + ScaleText(scale, duration_s, terminal);
  const Json& bias = Field(result, "bias");
  if (bias.is_array() && !bias.empty()) {
    // Where a scale factor was measured, the bias is a by-product.
    text += "\n" + BiasText(bias, duration_s, Field(result, "scale").empty(), terminal);
  }
  text += "\n" + DefectText(Field(result, "defects"), terminal);
  const std::string remarks = RemarksText(Field(result, "remarks"), terminal);
  if (!remarks.empty()) text += "\n" + terminal.Bold("Remarks") + "\n" + remarks;
  return text;
}

Json WithTraceRemarks(Json result, const Json& trace) {
  for (const Json& channel : Field(trace, "channels")) {
    const std::string axis = Text(channel, "gyro");
    const std::string scale = NamedEffects(channel, IsOfScale);
    const std::string gravity = NamedEffects(channel, IsBiasByGravity);
    if (!scale.empty()) {
      AddRemark(result, "scale", axis,
                fmt::format("the trace names {}: alpha holds for the rates, temperatures and poses "
                            "of this run only, and its ± does not count that; the model of the "
                            "trace has alpha and that effect",
                            scale));
    }
    if (!gravity.empty()) {
      AddRemark(result, "bias", axis,
                fmt::format("the trace names {}: this bias is the mean over the poses of this run, "
                            "the trace's baseline the one without gravity",
                            gravity));
      AddRemark(result, "scale", axis,
                fmt::format("the trace names {}: in several poses this bias is no number of the "
                            "sensor, and the noise given here contains what gravity does; the "
                            "trace has both apart",
                            gravity));
    }
  }
  return result;
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
