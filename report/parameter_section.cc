#include <fmt/format.h>

#include <array>
#include <cmath>

#include "report/noise_limits.h"
#include "report/number.h"
#include "report/sections.h"

namespace gyrobench::report {
namespace {

using calibration::ChannelTrace;
using calibration::ModelParameter;

struct Row {
  std::string name, unit;
  bool begins_group = false;
  Markup group;
};

// Columns of numbers are aligned over the whole table, so rows are collected before they are made.
class ParameterRows {
 public:
  void Add(const Markup& group, const std::vector<ModelParameter>& parameters) {
    bool first = true;
    for (const ModelParameter& parameter : parameters) {
      const Measured measured =
          RoundTogether(parameter.value, parameter.std_error, parameter.bound);
      rows_.push_back({parameter.name, UnitWithPower(measured.power, parameter.unit), first,
                       first ? group : Markup()});
      numbers_[0].push_back(measured.value);
      numbers_[1].push_back(measured.error);
      numbers_[2].push_back(measured.bound);
      const double alone = parameter.statistical_std_error;
      numbers_[3].push_back(
          FormatRatio((std::isfinite(alone) ? alone : parameter.std_error) / parameter.bound));
      first = false;
    }
  }

  bool empty() const { return rows_.empty(); }

  Markup ToMarkup() {
    for (auto& column : numbers_) AlignDecimals(column);
    Table table({{"Parameter"},
                 {"Value", true},
                 {"Standard error", true},
                 {"Cramér-Rao bound", true},
                 {"Unit"},
                 {"Error / bound", true}},
                "parameters");
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      if (rows_[i].begins_group) table.AddGroup(rows_[i].group);
      table.AddRow({Markup::Text(rows_[i].name), Markup::Text(numbers_[0][i]),
                    Markup::Text(numbers_[1][i]), Markup::Text(numbers_[2][i]),
                    Markup::Text(rows_[i].unit), Markup::Text(numbers_[3][i])});
    }
    return table.ToMarkup();
  }

 private:
  std::vector<Row> rows_;
  std::array<std::vector<std::string>, 4> numbers_;
};

std::string Whose(const calibration::TracedEffect& effect) {
  if (effect.owner == calibration::EffectOwner::kGyro) return "";
  return fmt::format(" (the {}'s, not the sensor's)", Name(effect.owner));
}

Markup BaselineNote(const ChannelTrace& channel) {
  const auto& baseline = channel.baseline;
  std::string text;
  if (std::isfinite(baseline.angle_rms_deg)) {
    text += fmt::format("an angle error of {} deg", FormatNumber(baseline.angle_rms_deg, 3));
  }
  if (std::isfinite(baseline.whitened_rms)) {
    text += fmt::format("{}{} times the noise", text.empty() ? "" : ", ",
                        FormatRatio(baseline.whitened_rms));
  }
  if (text.empty()) return {};
  return Paragraph("The baseline alone leaves, on the data that it was fitted to: " + text + ".",
                   "note");
}

std::string NoiseText(const NoiseFigure& figure) {
  return figure.hidden() ? "not seen" : FormatNumber(figure.value, 3);
}

}  // namespace

Markup ParameterSection(const calibration::TraceResult& trace) {
  Markup inside;
  for (const ChannelTrace& channel : trace.channels) {
    ParameterRows rows;
    rows.Add(Markup::Text("Baseline"), channel.baseline.parameters);
    for (const EffectGroup& group : GroupById(channel)) {
      for (std::size_t i = 0; i < group.size(); ++i) {
        const std::string which =
            group.size() == 1 ? "" : fmt::format(", {} of {}", i + 1, group.size());
        rows.Add(Code(group[i]->id) + Markup::Text(which + Whose(*group[i])), group[i]->parameters);
      }
    }
    if (rows.empty()) continue;
    const Markup head = Element("h3", "Axis " + AxisName(channel.axis));
    inside += Element("div", head + BaselineNote(channel) + rows.ToMarkup(), "short");
  }
  if (inside.empty()) inside = Paragraph("No parameter could be estimated.");
  if (!trace.reference_error.empty()) {
    const bool added = std::isfinite(trace.reference_uncertainty);
    inside += Paragraph("Of the reference: " + trace.reference_error + "." +
                            (added ? " The ratio of error to bound is that of the fit alone." : ""),
                        "note");
  }
  return Section("Parameters", inside, "");
}

Markup NoiseSection(const calibration::TraceResult& trace) {
  Table table({{"Axis"},
               {"Angle random walk [deg/√s]", true},
               {"Bias random walk [deg/s/√s]", true},
               {"Reference [deg]", true}});
  bool hidden = false;
  for (const ChannelTrace& channel : trace.channels) {
    const NoiseFigures noise = JudgeNoise(channel.noise, LongestDuration_s(trace));
    for (const NoiseFigure* figure :
         {&noise.angle_random_walk, &noise.bias_random_walk, &noise.reference})
      hidden = hidden || figure->hidden();
    table.AddRow({Markup::Text(AxisName(channel.axis)),
                  Markup::Text(NoiseText(noise.angle_random_walk)),
                  Markup::Text(NoiseText(noise.bias_random_walk)),
                  Markup::Text(NoiseText(noise.reference))});
  }
  if (table.empty()) return {};
  std::string note =
      "By restricted maximum likelihood; the reference's is the standard deviation of one angle of "
      "it.";
  if (hidden) {
    note +=
        " Not seen: below what these data could show. The reference's noise hides a smaller angle "
        "random walk, the angle random walk a smaller noise of bias or reference.";
  }
  return Section("Noise", table.ToMarkup() + Paragraph(note, "note"));
}

}  // namespace gyrobench::report
