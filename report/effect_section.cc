#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "report/number.h"
#include "report/reason.h"
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

// A true minus, and spaces at which no line breaks.
std::string Printed(std::string text) {
  for (std::size_t at = 0; (at = text.find(' ', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\u00A0");
  return text.starts_with('-') ? "−" + text.substr(1) : text;
}

std::string ParameterText(const TracedEffect& effect, double largest_rate_deg_s) {
  std::string text;
  for (const auto& parameter : effect.parameters) {
    text += (text.empty() ? "" : ", ") +
            Printed(fmt::format("{} = {}", parameter.name,
                                FormatMeasured(parameter.value, parameter.std_error,
                                               parameter.unit == "1" ? "" : parameter.unit)));
    const std::string share = ScaleAtRate(parameter.value, parameter.unit, largest_rate_deg_s);
    if (!share.empty()) text += fmt::format(" (of the rate: {})", Printed(share));
  }
  return text;
}

std::string Gain(const HeldOut& figure, const std::string& unit, bool ratio) {
  if (!std::isfinite(figure.before) || !std::isfinite(figure.after)) return {};
  return fmt::format("without and with it, held out: {}; {}", BeforeAfter(figure, unit, ratio),
                     Reduction(figure));
}

std::string ChosenOn(const TracedEffect& effect) {
  return effect.chosen_on == calibration::ChosenOn::kTrainingPart
             ? "on the part of the data that it was then not tried on, too"
             : "on all data only: two thirds of them alone do not ask for it, or are too few; the "
               "figures held out are of data that its coefficients did not see, but its choice did";
}

Markup Facts(const TracedEffect& effect, double largest_rate_deg_s) {
  Markup lines;
  AddFact(lines, "Found", Markup::Text(ParameterText(effect, largest_rate_deg_s)));
  AddFact(lines, "Chance",
          Markup::Text(FormatPValue(effect.p_value) +
                       ", after correction for everything that was tried"));
  AddFact(lines, "Chosen", Markup::Text(ChosenOn(effect)));
  AddFact(lines, "Angle error", Markup::Text(Gain(effect.heldout_angle_rms_deg, "deg", false)));
  AddFact(lines, "Residual / noise", Markup::Text(Gain(effect.heldout_whitened_rms, "", true)));
  return lines;
}

// Several effects of one id: a line each, figures held out without it and with it.
Markup Instances(const EffectGroup& group, double largest_rate_deg_s) {
  Table table({{""},
               {"Found"},
               {"Chance, corrected"},
               {"Chosen on"},
               {"Angle error [deg]", true},
               {"Residual / noise", true}});
  for (std::size_t i = 0; i < group.size(); ++i) {
    const TracedEffect& effect = *group[i];
    table.AddRow(
        {Markup::Text(fmt::format("{}", i + 1)),
         Markup::Text(ParameterText(effect, largest_rate_deg_s)),
         Markup::Text(FormatPValue(effect.p_value)),
         Markup::Text(effect.chosen_on == calibration::ChosenOn::kTrainingPart ? "a part"
                                                                               : "all data only"),
         Markup::Text(BeforeAfter(effect.heldout_angle_rms_deg, "", false)),
         Markup::Text(BeforeAfter(effect.heldout_whitened_rms, "", true))});
  }
  return table.ToMarkup();
}

// The equations of a group, each once: those of curves differ by their numbers.
Markup Equations(const EffectGroup& group) {
  Markup codes;
  std::set<std::string> said = {""};
  for (const TracedEffect* effect : group) {
    if (!said.insert(effect->equation).second) continue;
    if (!codes.empty()) codes += Markup::Text("; ");
    codes += Code(effect->equation);
  }
  return codes;
}

Markup Card(const ChannelTrace& channel, const EffectGroup& group) {
  const TracedEffect& first = *group.front();
  const double rate_deg_s = LargestRate_deg_s(channel);
  Markup lines;
  AddFact(lines, "Cause", Markup::Text(first.cause));
  AddFact(lines, "Equation", Equations(group));
  if (group.size() == 1) lines += Facts(first, rate_deg_s);
  AddFact(lines, "Origin", Markup::Text(OriginWords(first.origin)));
  Markup head = Element("span", "Axis " + AxisName(channel.axis), "axis") + Code(first.id);
  if (group.size() > 1) head += Markup::Text(fmt::format(", {} times", group.size()));
  Markup card = Element("h4", head) + Element("dl", lines);
  if (group.size() > 1) card += Instances(group, rate_deg_s);
  return Element("article", card);
}

Markup CardsOf(const TraceResult& trace, EffectOwner owner) {
  Markup cards;
  for (const ChannelTrace& channel : trace.channels) {
    for (const EffectGroup& group : GroupById(channel)) {
      if (group.front()->owner == owner) cards += Card(channel, group);
    }
  }
  return cards;
}

// One effect that was not to be seen, with the axes of which that holds.
struct Unseen {
  std::string id, kind, figures, shown_by, axes;
};

std::vector<Unseen> AllUnseen(const TraceResult& trace) {
  std::vector<Unseen> all;
  for (const ChannelTrace& channel : trace.channels) {
    const std::string axis = AxisName(channel.axis);
    for (const auto& one : channel.unidentifiable) {
      const Reason reason = SplitReason(one.because);
      const auto same = std::find_if(all.begin(), all.end(), [&](const Unseen& other) {
        return other.id == one.id && other.kind == reason.kind && other.figures == reason.figures &&
               other.shown_by == one.settled_by;
      });
      if (same == all.end()) {
        all.push_back({one.id, reason.kind, reason.figures, one.settled_by, axis});
      } else {
        same->axes += ",\u00A0" + axis;
      }
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Unseen& a, const Unseen& b) { return a.id < b.id; });
  return all;
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
  Markup inside = Element("h3", "The gyro's own: the calibration corrects them");
  inside +=
      gyro.empty()
          ? Paragraph("None. The calibration corrects the baseline alone.")
          : Paragraph(
                "But for what no correction sample by sample can undo: a lag, a step or a tone "
                "of this run, the Earth's rotation.",
                "note") +
                gyro;
  if (!reference.empty()) {
    inside +=
        Element("h3", "The reference's: errors of the comparison, not corrected in the sensor") +
        reference;
  }
  if (!bench.empty()) {
    inside +=
        Element("h3", "The bench's: errors of the comparison, not corrected in the sensor") + bench;
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
  if (trace.channels.empty()) return {};
  const std::vector<Unseen> all = AllUnseen(trace);
  if (all.empty()) {
    return Section("What these data cannot show",
                   Paragraph("Every effect of the catalogue would have shown."));
  }
  Table table({{"Effect"}, {"Axis"}, {"Figures, in that order"}, {"What would show it"}});
  std::set<std::string> said;
  for (const Unseen& first : all) {
    if (!said.insert(first.kind).second) continue;
    table.AddGroup(Markup::Text(first.kind));
    for (const Unseen& one : all) {
      if (one.kind != first.kind) continue;
      table.AddRow({Code(one.id), Markup::Text(one.axes), Markup::Text(one.figures),
                    Markup::Text(one.shown_by)});
    }
  }
  return Section("What these data cannot show", table.ToMarkup(), "");
}

}  // namespace gyrobench::report
