#include <fmt/format.h>

#include <cmath>

#include "report/number.h"
#include "report/sections.h"

namespace gyrobench::report {
namespace {

using calibration::ChannelTrace;
using calibration::EffectOrigin;
using calibration::EffectOwner;
using calibration::HeldOut;
using calibration::TracedEffect;
using calibration::TraceResult;

const char* OriginWords(EffectOrigin origin) {
  switch (origin) {
    case EffectOrigin::kCatalogue:
      return "from the catalogue of effects";
    case EffectOrigin::kComposed:
      return "composed of covariates: what it follows is known, its "
             "physical cause is not";
    case EffectOrigin::kEmpirical:
      return "empirical curve: what it follows is known, its cause "
             "is not";
  }
  return "";
}

std::string ParameterText(const TracedEffect& effect) {
  std::string text;
  for (const auto& parameter : effect.parameters) {
    text += fmt::format("{}{} = {}", text.empty() ? "" : ",  ", parameter.name,
                        FormatMeasured(parameter.value, parameter.std_error, parameter.unit));
  }
  return text;
}

std::string Gain(const HeldOut& figure, const std::string& unit, bool ratio) {
  if (!std::isfinite(figure.before) || !std::isfinite(figure.after)) return {};
  return fmt::format("without and with it, held out: {}; {}", BeforeAfter(figure, unit, ratio),
                     Reduction(figure));
}

Markup Card(const ChannelTrace& channel, const TracedEffect& effect) {
  Markup lines;
  AddFact(lines, "Cause", Markup::Text(effect.cause));
  AddFact(lines, "Equation", effect.equation.empty() ? Markup() : Code(effect.equation));
  AddFact(lines, "Found", Markup::Text(ParameterText(effect)));
  AddFact(lines, "Chance",
          Markup::Text(FormatPValue(effect.p_value) +
                       ", after correction for everything that was tried"));
  AddFact(lines, "Angle error", Markup::Text(Gain(effect.heldout_angle_rms_deg, "deg", false)));
  AddFact(lines, "Residual / noise", Markup::Text(Gain(effect.heldout_whitened_rms, "", true)));
  AddFact(lines, "Origin", Markup::Text(OriginWords(effect.origin)));
  const Markup head = Element("span", "Axis " + AxisName(channel.axis), "axis") + Code(effect.id);
  return Element("article", Element("h4", head) + Element("dl", lines));
}

Markup CardsOf(const TraceResult& trace, EffectOwner owner) {
  Markup cards;
  for (const ChannelTrace& channel : trace.channels) {
    for (const TracedEffect& effect : channel.effects) {
      if (effect.owner == owner) cards += Card(channel, effect);
    }
  }
  return cards;
}

Markup Names(const std::vector<std::string>& ids) {
  Markup names;
  for (const std::string& id : ids) {
    if (!names.empty()) names += Markup::Text(", ");
    names += Code(id);
  }
  return names;
}

}  // namespace

Markup EffectSection(const TraceResult& trace) {
  const Markup gyro = CardsOf(trace, EffectOwner::kGyro);
  const Markup reference = CardsOf(trace, EffectOwner::kReference);
  const Markup bench = CardsOf(trace, EffectOwner::kBench);
  if (gyro.empty() && reference.empty() && bench.empty()) {
    return Section("Effects", Paragraph("No effect was added to the baseline."));
  }
  Markup inside = Element("h3", "The gyro's own: they go into the calibration");
  inside += gyro.empty() ? Paragraph("None. The calibration is the baseline.") : gyro;
  if (!reference.empty()) {
    inside +=
        Element("h3", "The reference's: removed from the comparison, not in the calibration") +
        reference;
  }
  if (!bench.empty()) {
    inside +=
        Element("h3", "The bench's: removed from the comparison, not in the calibration") + bench;
  }
  return Section("Effects, and whose they are", inside, "");
}

Markup RivalSection(const TraceResult& trace) {
  Table table({{"Axis"}, {"Named"}, {"Cannot be told from"}, {"What would settle it"}});
  bool named = false;
  for (const ChannelTrace& channel : trace.channels) {
    for (const TracedEffect& effect : channel.effects) {
      named = true;
      if (effect.rivals.empty() && effect.settled_by.empty()) continue;
      table.AddRow({Markup::Text(AxisName(channel.axis)), Code(effect.id), Names(effect.rivals),
                    Markup::Text(effect.settled_by)});
    }
  }
  if (!named) return {};
  constexpr const char* kNone =
      "None: these data tell each effect that was named from all others of the catalogue.";
  return Section("Rivals", table.empty() ? Paragraph(kNone) : table.ToMarkup());
}

Markup UnidentifiableSection(const TraceResult& trace) {
  Table table({{"Axis"}, {"Effect"}, {"Because"}, {"What would show it"}});
  for (const ChannelTrace& channel : trace.channels) {
    for (const auto& effect : channel.unidentifiable) {
      table.AddRow({Markup::Text(AxisName(channel.axis)), Code(effect.id),
                    Markup::Text(effect.because), Markup::Text(effect.settled_by)});
    }
  }
  if (trace.channels.empty()) return {};
  return Section("What these data cannot show",
                 table.empty() ? Paragraph("Every effect of the catalogue would have shown.")
                               : table.ToMarkup());
}

}  // namespace gyrobench::report
