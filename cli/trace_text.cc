#include "cli/trace_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <vector>

#include "base/measurement.h"
#include "cli/effect_text.h"
#include "cli/json_field.h"
#include "cli/noise_text.h"
#include "cli/number_text.h"
#include "cli/unseen_text.h"
#include "cli/vector_text.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;

bool HasEffects(const Json& channel) { return !Field(channel, "effects").empty(); }

// A sentence as a part of another one.
std::string Clause(std::string sentence) {
  if (sentence.ends_with('.')) sentence.pop_back();
  if (!sentence.empty())
    sentence.front() =
        static_cast<char>(std::tolower(static_cast<unsigned char>(sentence.front())));
  return sentence;
}

// Where nothing was fitted there is no figure of the baseline.
bool Fitted(const Json& channel) {
  const Json& baseline = Field(channel, "baseline");
  return !baseline.is_object() || std::isfinite(Number(baseline, "whitened_rms"));
}

// What is said of a channel without effects. Where nothing was fitted, nothing was looked at.
std::string WithoutEffects(const Json& channel) {
  const std::string verdict = Text(channel, "verdict"), summary = Text(channel, "summary");
  if (verdict != "none")
    return VerdictWords(verdict) + (summary.empty() ? "" : "; " + Clause(summary));
  return Fitted(channel) ? VerdictWords(verdict) : "not traced; the remarks say why";
}

// "partly explained by angle.latency"
std::string VerdictSentence(const Json& channel) {
  if (!HasEffects(channel)) return WithoutEffects(channel);
  return fmt::format("{} by {}", VerdictWords(Text(channel, "verdict")),
                     NamesOfEffects(Field(channel, "effects")));
}

std::string Headline(const Json& channel, const Terminal& terminal) {
  std::string text = terminal.Bold(fmt::format("Gyro {}:", Text(channel, "gyro"))) + " " +
                     VerdictSentence(channel);
  const std::string angle = BeforeAfter(Field(channel, "heldout_angle_rms_deg"));
  if (HasEffects(channel) && angle != "-")
    text += fmt::format("; angle error of held-out data {} deg", angle);
  return Paragraph(text, terminal, 0);
}

std::string Reduction(const Json& held_out) {
  const std::vector<double> interval = Numbers(Field(held_out, "reduction_ci95"));
  if (interval.size() != 2 || !std::isfinite(interval[0]) || !std::isfinite(interval[1])) return "";
  const double low = 100.0 * interval[0], high = 100.0 * interval[1];
  if (low < 0.0 && high > 0.0) return fmt::format("{:.0f} % more .. {:.0f} % less", -low, high);
  if (low < 0.0) return fmt::format("{:.0f} .. {:.0f} % more", -high, -low);
  return fmt::format("{:.0f} .. {:.0f} % less", low, high);
}

void AddRow(Rows& rows, const std::string& name, const std::string& value, const std::string& unit,
            const std::string& note = "") {
  if (value != "-" && !value.empty()) rows.push_back({name, value, unit, note});
}

// What two thirds of the data ask for, where that is not what all of them do.
std::string TrainingEffects(const Json& channel) {
  const Json& training = Field(channel, "training_effects");
  if (!training.is_array()) return "";
  std::vector<std::string> found, named;
  for (const Json& id : training) found.push_back(Plain(id));
  for (const Json& effect : Field(channel, "effects")) named.push_back(Text(effect, "id"));
  std::ranges::sort(found);
  std::ranges::sort(named);
  if (found == named) return "";
  return found.empty()
             ? "the baseline alone, as two thirds of the data ask for no effect"
             : fmt::format("{}, as two thirds of the data ask for", fmt::join(found, ", "));
}

void AddErrors(Rows& rows, const Json& channel) {
  if (!HasEffects(channel)) {
    const Json& baseline = Field(channel, "baseline");
    AddRow(rows, "angle error", FormatNumber(Number(baseline, "angle_rms_deg"), 3), "deg");
    AddRow(rows, "whitened rms", FormatNumber(Number(baseline, "whitened_rms"), 4), "",
           "1: as the noise explains");
    return;
  }
  const Json& angle = Field(channel, "heldout_angle_rms_deg");
  const std::string reduction = Reduction(angle);
  AddRow(rows, "angle error, held out", BeforeAfter(angle), "deg",
         reduction + (reduction.empty() ? "" : " (95 %); ") +
             "from two thirds, tried on the other third");
  AddRow(rows, "whitened rms, held out", BeforeAfter(Field(channel, "heldout_whitened_rms")), "",
         "1: as the noise explains");
  AddRow(rows, "angle error, forecast", BeforeAfter(Field(channel, "forecast_angle_rms_deg")),
         "deg", "from the first 60 %, tried on the last 40 %");
  AddRow(rows, "angle error, all data", BeforeAfter(Field(channel, "fitted_angle_rms_deg")), "deg",
         "of the data that it was fitted to");
}

std::string FiguresText(const Json& channel, const Terminal& terminal, double duration_s) {
  Rows rows;
  AddErrors(rows, channel);
  for (const NoiseLine& line : NoiseLines(Field(channel, "noise"), duration_s))
    AddRow(rows, line.name, line.value, line.unit, line.note);
  if (rows.empty()) return "";
  const std::string figures =
      "  figures\n" +
      FitLines(AlignColumns(rows, std::vector<Align>(4, Align::kLeft), 4), terminal);
  const std::string found = HasEffects(channel) ? TrainingEffects(channel) : "";
  return found.empty() ? figures
                       : figures + Paragraph("held out is the error of " + found, terminal, 4);
}

std::string BaselineText(const Json& channel, const Terminal& terminal) {
  const Json& baseline = Field(channel, "baseline");
  const std::string parameters = ParametersText(Field(baseline, "parameters"), terminal, kMissing);
  if (parameters.empty()) return "";
  const double reference_degC = Number(baseline, "reference_degC");
  const std::string origin =
      std::isfinite(reference_degC)
          ? Paragraph(fmt::format("zero_rate_offset is that at {:.2f} degC, from which the powers "
                                  "of the temperature are counted",
                                  reference_degC),
                      terminal, 4)
          : "";
  return "  baseline\n" + parameters + origin;
}

std::string FindingText(const Json& finding) {
  const std::string says = Text(finding, "says"), covariate = Text(finding, "covariate");
  const std::string test =
      Text(finding, "test") + (covariate.empty() ? "" : " against " + covariate);
  return fmt::format("{} ({})", says.empty() ? test : says, PValue(Number(finding, "p_value")));
}

std::string RemainingText(const Json& remaining, bool fitted, const Terminal& terminal) {
  if (!fitted) return "";
  std::string text;
  for (const Json& finding : Field(remaining, "findings"))
    text += Paragraph(FindingText(finding), terminal, 4);
  if (!text.empty()) return "  what remains\n" + text;
  const Json& white = Field(remaining, "white");
  if (!white.is_boolean()) return "";
  return white.get<bool>() ? "  what remains: white noise\n"
                           : "  what remains: the rounding of the encoder, and noise\n";
}

std::string ChannelText(const Json& channel, const Terminal& terminal, double largest_rate_deg_s,
                        double duration_s) {
  return EffectsText(Field(channel, "effects"), terminal, largest_rate_deg_s) +
         BaselineText(channel, terminal) + FiguresText(channel, terminal, duration_s) +
         RemainingText(Field(channel, "remaining"), Fitted(channel), terminal);
}

double LongestDuration_s(const Json& trace) {
  double longest_s = kMissing;
  for (const Json& input : Field(trace, "inputs"))
    longest_s = std::fmax(longest_s, Number(input, "duration_s"));
  return longest_s;
}

std::string ReferenceText(const Json& trace, const Terminal& terminal) {
  const std::string says = Text(Field(trace, "reference_error"), "says");
  return says.empty() ? "" : Paragraph("reference: " + says, terminal, 0);
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

std::string TraceText(const Json& trace, const Terminal& terminal,
                      const std::vector<double>& largest_rates_deg_s) {
  const Json& channels = Field(trace, "channels");
  std::string text;
  for (const Json& channel : channels) text += Headline(channel, terminal);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const double rate = i < largest_rates_deg_s.size() ? largest_rates_deg_s[i] : kMissing;
    const std::string inside = ChannelText(channels[i], terminal, rate, LongestDuration_s(trace));
    if (inside.empty()) continue;
    text += "\n";
    if (channels.size() > 1)
      text += terminal.Bold(fmt::format("Gyro {}", Text(channels[i], "gyro"))) + "\n";
    text += inside;
  }
  for (const std::string& part :
       {VectorText(Field(trace, "vector"), terminal), ReferenceText(trace, terminal),
        UnseenText(channels, terminal),
        InputsText(Field(trace, "inputs"), terminal) + TraceRemarks(trace, terminal)}) {
    if (!part.empty()) text += (text.empty() ? "" : "\n") + part;
  }
  return text;
}

std::string TraceSummary(const Json& trace, const Terminal& terminal) {
  std::string text;
  for (const Json& channel : Field(trace, "channels")) {
    text += Paragraph(fmt::format("gyro {}: {}", Text(channel, "gyro"), VerdictSentence(channel)),
                      terminal, 2);
  }
  return text.empty() ? "" : terminal.Bold("Trace") + "\n" + text;
}

}  // namespace gyrobench::cli
