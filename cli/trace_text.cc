#include "cli/trace_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cli/json_field.h"
#include "cli/number_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

std::vector<std::string> Texts(const Json& list) {
  std::vector<std::string> texts;
  for (const Json& value : list) texts.push_back(Plain(value));
  return texts;
}

std::string Paragraph(const std::string& text, const Terminal& terminal, int indent) {
  const std::string pad(static_cast<std::size_t>(indent), ' ');
  if (!terminal.is_terminal) return pad + text + "\n";
  return pad + Wrap(text, terminal.columns - indent, indent + 2) + "\n";
}

std::string PValue(double p) {
  if (!std::isfinite(p)) return "-";
  return p < 1e-16 ? "< 1e-16" : fmt::format("{:.2g}", p);
}

// "0.62 → 0.15"
std::string BeforeAfter(const Json& held_out) {
  const double before = Number(held_out, "before"), after = Number(held_out, "after");
  if (!std::isfinite(before) && !std::isfinite(after)) return "-";
  return FormatNumber(before, 3) + " → " + FormatNumber(after, 3);
}

std::string Reduction(const Json& held_out) {
  const std::vector<double> interval = Numbers(Field(held_out, "reduction_ci95"));
  if (interval.size() != 2 || !std::isfinite(interval[0]) || !std::isfinite(interval[1])) return "";
  return fmt::format("{:.0f} .. {:.0f} % less", 100.0 * interval[0], 100.0 * interval[1]);
}

std::string ParameterValue(const Json& parameter) {
  return FormatMeasured(Number(parameter, "value"), Number(parameter, "std_error"));
}

std::string Whose(const Json& effect) {
  const std::string owner = Text(effect, "owner");
  return owner.empty() || owner == "gyro" ? "gyro" : owner;
}

std::string EffectTable(const Json& effects, const Terminal& terminal) {
  Rows rows = {{"effect", "of", "angle error, deg", "whitened rms", "p-value"}};
  for (const Json& effect : effects) {
    rows.push_back(
        {Text(effect, "id"), Whose(effect), BeforeAfter(Field(effect, "heldout_angle_rms_deg")),
         BeforeAfter(Field(effect, "heldout_whitened_rms")), PValue(Number(effect, "p_value"))});
  }
  return FitLines(AlignColumns(rows, std::vector<Align>(5, Align::kLeft), 2), terminal);
}

std::string EffectsText(const Json& effects, const Terminal& terminal) {
  if (!effects.is_array() || effects.empty()) return "";
  std::string text = EffectTable(effects, terminal);
  for (const Json& effect : effects) {
    std::string line = Text(effect, "id");
    if (const std::string equation = Text(effect, "equation"); !equation.empty())
      line += ": " + equation;
    if (const std::string cause = Text(effect, "cause"); !cause.empty()) line += "; " + cause;
    text += Paragraph(line, terminal, 2);
    const std::vector<std::string> rivals = Texts(Field(effect, "rivals"));
    if (!rivals.empty()) {
      text += Paragraph(fmt::format("or {}: these data cannot tell", fmt::join(rivals, ", or ")),
                        terminal, 4);
    }
    if (const std::string by = Text(effect, "settled_by"); !by.empty())
      text += Paragraph("settled by: " + by, terminal, 4);
  }
  return text;
}

void AddRow(Rows& rows, const std::string& name, const std::string& value, const std::string& unit,
            const std::string& note = "") {
  if (value != "-" && !value.empty()) rows.push_back({name, value, unit, note});
}

void AddParameters(Rows& rows, const std::string& of, const Json& parameters) {
  for (const Json& parameter : parameters) {
    const std::string unit = Text(parameter, "unit");
    AddRow(rows, of + ": " + Text(parameter, "name"), ParameterValue(parameter),
           unit == "1" ? "" : unit);
  }
}

std::string FiguresText(const Json& channel, const Terminal& terminal) {
  Rows rows;
  const Json& baseline = Field(channel, "baseline");
  AddParameters(rows, "baseline", Field(baseline, "parameters"));
  for (const Json& effect : Field(channel, "effects"))
    AddParameters(rows, Text(effect, "id"), Field(effect, "parameters"));
  if (!Field(channel, "effects").empty()) {
    const Json& angle = Field(channel, "heldout_angle_rms_deg");
    AddRow(rows, "angle error, held out", BeforeAfter(angle), "deg", Reduction(angle));
    AddRow(rows, "whitened rms, held out", BeforeAfter(Field(channel, "heldout_whitened_rms")), "",
           "1: as the noise explains");
    AddRow(rows, "angle error, forecast", BeforeAfter(Field(channel, "forecast_angle_rms_deg")),
           "deg", "first 60 % of the time learnt, rest foretold");
  } else {
    AddRow(rows, "angle error", FormatNumber(Number(baseline, "angle_rms_deg"), 3), "deg");
    AddRow(rows, "whitened rms", FormatNumber(Number(baseline, "whitened_rms"), 4), "",
           "1: as the noise explains");
  }
  const Json& noise = Field(channel, "noise");
  AddRow(rows, "angle random walk", FormatNumber(Number(noise, "angle_random_walk_deg_sqrt_s"), 3),
         "deg/sqrt(s)");
  AddRow(rows, "bias random walk", FormatNumber(Number(noise, "bias_random_walk_deg_s_sqrt_s"), 3),
         "deg/s/sqrt(s)");
  AddRow(rows, "reference noise", FormatNumber(Number(noise, "reference_deg"), 3), "deg");
  return FitLines(AlignColumns(rows, std::vector<Align>(4, Align::kLeft), 2), terminal);
}

std::string RemainingText(const Json& remaining, const Terminal& terminal) {
  std::string text;
  for (const Json& finding : Field(remaining, "findings")) {
    std::string line = Text(finding, "test");
    if (const std::string covariate = Text(finding, "covariate"); !covariate.empty())
      line += " against " + covariate;
    line += fmt::format(" (p = {})", PValue(Number(finding, "p_value")));
    if (const std::string says = Text(finding, "says"); !says.empty()) line += ": " + says;
    text += Paragraph(line, terminal, 4);
  }
  if (!text.empty()) return "  what remains\n" + text;
  const Json& white = Field(remaining, "white");
  return white.is_boolean() && white.get<bool>() ? "  what remains: white noise\n" : "";
}

std::string UnidentifiableText(const Json& list, const Terminal& terminal) {
  if (!list.is_array() || list.empty()) return "";
  std::string text = "  not to be seen in these data\n";
  for (const Json& one : list) {
    std::string line = Text(one, "id") + ": " + Text(one, "because");
    if (const std::string by = Text(one, "settled_by"); !by.empty()) line += "; shown by: " + by;
    text += Paragraph(line, terminal, 4);
  }
  return text;
}

std::string RemarkLines(const Json& remarks, const Terminal& terminal) {
  std::string text;
  for (const std::string& remark : Texts(remarks)) text += Paragraph("! " + remark, terminal, 2);
  return text;
}

std::string Heading(const Json& channel) {
  return fmt::format("Gyro {}: {}", Text(channel, "gyro"), VerdictWords(Text(channel, "verdict")));
}

std::string ChannelText(const Json& channel, const Terminal& terminal) {
  std::string text = terminal.Bold(Heading(channel)) + "\n";
  if (const std::string summary = Text(channel, "summary"); !summary.empty())
    text += Paragraph(summary, terminal, 0);
  const std::string effects = EffectsText(Field(channel, "effects"), terminal);
  if (!effects.empty()) text += "\n" + effects + "\n";
  return text + FiguresText(channel, terminal) +
         RemainingText(Field(channel, "remaining"), terminal) +
         UnidentifiableText(Field(channel, "unidentifiable"), terminal) +
         RemarkLines(Field(channel, "remarks"), terminal);
}

std::string InputsText(const Json& inputs, const Terminal& terminal) {
  std::string text;
  for (const Json& input : inputs) {
    std::vector<std::string> defects;
    for (const Json& defect : Field(input, "defects")) {
      const double first = Number(defect, "first_t_s");
      const std::string at = std::isfinite(first) ? fmt::format(", first at {:.3f} s", first) : "";
      defects.push_back(
          fmt::format("{} {}{}", FormatCount(Integer(defect, "count")), Text(defect, "kind"), at));
    }
    text += Paragraph(
        fmt::format(
            "{}: {} samples in {}; {}", Text(input, "file"), FormatCount(Integer(input, "samples")),
            FormatDuration(Number(input, "duration_s")),
            defects.empty() ? "no defects" : fmt::format("defects: {}", fmt::join(defects, "; "))),
        terminal, 0);
  }
  return text;
}

}  // namespace

std::string VerdictWords(const std::string& verdict) {
  if (verdict == "none") return "nothing beyond the baseline";
  std::string words = verdict;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

std::string TraceText(const Json& trace, const Terminal& terminal) {
  std::string text;
  for (const Json& channel : Field(trace, "channels"))
    text += (text.empty() ? "" : "\n") + ChannelText(channel, terminal);
  text += (text.empty() ? "" : "\n") + InputsText(Field(trace, "inputs"), terminal);
  return text + RemarkLines(Field(trace, "remarks"), terminal);
}

std::string TraceSummary(const Json& trace, const Terminal& terminal) {
  std::string text;
  for (const Json& channel : Field(trace, "channels")) {
    std::vector<std::string> ids;
    for (const Json& effect : Field(channel, "effects")) {
      std::vector<std::string> names = {Text(effect, "id")};
      for (const std::string& rival : Texts(Field(effect, "rivals"))) names.push_back(rival);
      ids.push_back(fmt::format("{}", fmt::join(names, " or ")));
    }
    std::string line =
        fmt::format("gyro {}: {}", Text(channel, "gyro"), VerdictWords(Text(channel, "verdict")));
    if (!ids.empty()) line += fmt::format(" by {}", fmt::join(ids, ", "));
    text += Paragraph(line, terminal, 2);
  }
  return text.empty() ? "" : terminal.Bold("Trace") + "\n" + text;
}

}  // namespace gyrobench::cli
