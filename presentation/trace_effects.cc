#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::ChannelTrace;
using calibration::ChosenOn;
using calibration::EffectOrigin;
using calibration::ModelParameter;
using calibration::TracedEffect;

// "(2) ", and nothing where there is but one.
std::string Ordinal(const EffectGroup& group, std::size_t i) {
  return group.size() == 1 ? "" : fmt::format("({}) ", i + 1);
}

const char* OriginWords(EffectOrigin origin) {
  switch (origin) {
    case EffectOrigin::kCatalogue:
      return "from the catalogue";
    case EffectOrigin::kComposed:
      return "composed of covariates: what it follows is known, its physical cause is not";
    case EffectOrigin::kEmpirical:
      return "empirical curve: what it follows is known, its cause is not";
  }
  return "";
}

bool IsMarked(const TracedEffect& effect) { return effect.chosen_on == ChosenOn::kAllData; }

const char* ChosenOnWords(const TracedEffect& effect) {
  return IsMarked(effect)
             ? "all data only: two thirds of them alone do not ask for it, or are too few"
             : "two thirds of the data, then tried on the rest; all of them ask for it as well";
}

// "Chosen on: ...", for each of a group where it is not the same of all.
Text ChosenOnText(const EffectGroup& group) {
  const bool alike = std::ranges::all_of(
      group, [&](const TracedEffect* one) { return IsMarked(*one) == IsMarked(*group.front()); });
  if (alike) return std::string("Chosen on: ") + ChosenOnWords(*group.front());
  std::vector<Text> each;
  for (std::size_t i = 0; i < group.size(); ++i)
    each.emplace_back(Ordinal(group, i) + ChosenOnWords(*group[i]));
  return "Chosen on: " + Join(each, "; ");
}

bool SameEquation(const EffectGroup& group) {
  return std::ranges::all_of(group, [&](const TracedEffect* effect) {
    return effect->equation == group.front()->equation;
  });
}

std::string PrintedUnit(const ModelParameter& parameter) {
  return parameter.unit == "1" ? "" : parameter.unit;
}

std::vector<std::string> Heads(const TracedEffect& effect) {
  std::vector<std::string> heads;
  for (const ModelParameter& parameter : effect.parameters) {
    const std::string unit = PrintedUnit(parameter);
    heads.push_back(parameter.name + (unit.empty() ? "" : ", " + unit));
  }
  return heads;
}

bool HasReasons(const TracedEffect& effect) {
  return std::ranges::any_of(effect.parameters,
                             [](const ModelParameter& one) { return one.because.has_value(); });
}

// One line an effect, one column a parameter.
Table TableOfGroup(const EffectGroup& group) {
  Table table{{{}}, {}};
  for (const std::string& head : Heads(*group.front())) table.columns.push_back({head, kNumber});
  for (std::size_t i = 0; i < group.size(); ++i) {
    std::vector<Text> cells = {fmt::format("({})", i + 1)};
    for (const ModelParameter& parameter : group[i]->parameters)
      cells.push_back(Number(FormatMeasured(parameter.value, parameter.std_error)));
    table.Add(std::move(cells));
  }
  return table;
}

// 1 of "1/(deg/s)", 2 of "1/(deg/s)^2"; 0 of another unit.
int PowerOfRate(const std::string& unit) {
  const std::string one = "1/(deg/s)";
  if (!unit.starts_with(one)) return 0;
  if (unit.size() == one.size()) return 1;
  return unit[one.size()] == '^' ? std::max(0, std::atoi(unit.c_str() + one.size() + 1)) : 0;
}

}  // namespace

std::vector<EffectGroup> GroupById(const ChannelTrace& channel) {
  std::vector<EffectGroup> groups;
  for (const TracedEffect& effect : channel.effects) {
    const auto same = std::ranges::find_if(
        groups, [&](const EffectGroup& group) { return group.front()->id == effect.id; });
    if (same == groups.end()) {
      groups.push_back({&effect});
    } else {
      same->push_back(&effect);
    }
  }
  return groups;
}

Table GainTable(const std::vector<EffectGroup>& groups) {
  Table table{{{"effect, without → with"},
               {"of"},
               {"angle error, deg", kNumber},
               {"its change", Column::Kind::kText, true},
               {"whitened rms", kNumber},
               {"its change", Column::Kind::kText, true},
               {"chance, corrected"}},
              {}};
  for (const EffectGroup& group : groups) {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const TracedEffect& effect = *group[i];
      table.Add({Ordinal(group, i) + Code(effect.id) + (IsMarked(effect) ? " *" : ""),
                 Name(effect.owner),
                 Number(BeforeAfter(effect.heldout_angle_rms_deg, FormatFigure)),
                 Reduction(effect.heldout_angle_rms_deg),
                 Number(BeforeAfter(effect.heldout_whitened_rms, FormatRatio)),
                 Reduction(effect.heldout_whitened_rms), Number(FormatPValue(effect.p_value))});
    }
  }
  return table;
}

Document ExplainGains(const std::vector<EffectGroup>& groups) {
  Document notes;
  if (groups.empty()) return notes;
  Add(notes,
      Paragraph{"The chance p is that after correction for everything that was tried.", "note"});
  const bool any = std::ranges::any_of(groups, [](const EffectGroup& group) {
    return std::ranges::any_of(group, [](const TracedEffect* one) { return IsMarked(*one); });
  });
  if (!any) return notes;
  Add(notes,
      Paragraph{
          "* found in all data, but not in the two thirds of them that are then tried on the rest, "
          "or there are too few data for that. Its figures compare all that is named with the same "
          "without it; all data had a part in choosing it, so that they are no independent test, "
          "and not to be compared with those of a row without the mark.",
          "note"});
  return notes;
}

std::string Whose(const TracedEffect& effect) {
  if (effect.owner == calibration::EffectOwner::kGyro) return "";
  return fmt::format(" (the {}'s, not the sensor's)", Name(effect.owner));
}

Text AboutEffects(const EffectGroup& group) {
  const TracedEffect& first = *group.front();
  return Join(
      {SameEquation(group) ? Code(first.equation) : Text(), first.cause, OriginWords(first.origin)},
      "; ");
}

Document EffectBlocks(const EffectGroup& group, double largest_rate_deg_s) {
  Document blocks;
  if (!SameEquation(group)) {
    for (std::size_t i = 0; i < group.size(); ++i)
      Add(blocks, Paragraph{Ordinal(group, i) + Code(group[i]->equation)});
  }
  // A line of a table of several has no place for a reason.
  const bool alike = std::ranges::all_of(group, [&](const TracedEffect* effect) {
    return Heads(*effect) == Heads(*group.front()) && !HasReasons(*effect);
  });
  if (group.size() > 1 && alike) {
    Add(blocks, TableOfGroup(group));
  } else {
    for (std::size_t i = 0; i < group.size(); ++i) {
      Add(blocks, Paragraph{Ordinal(group, i)});
      Add(blocks, ParameterTable(group[i]->parameters, largest_rate_deg_s));
    }
  }
  Add(blocks, Paragraph{ChosenOnText(group)});
  for (std::size_t i = 0; i < group.size(); ++i) {
    const Text rivals = RivalsText(*group[i]);
    if (!rivals.empty()) Add(blocks, Paragraph{Ordinal(group, i) + rivals});
  }
  return blocks;
}

Text RivalsText(const TracedEffect& effect) {
  std::vector<Text> rivals;
  for (const std::string& rival : effect.rivals) rivals.push_back(Code(rival));
  const Text named = Join(rivals, ", or ");
  return Join({named.empty() ? Text() : "or " + named + ": these data cannot tell",
               effect.settled_by.empty() ? "" : "settled by: " + effect.settled_by},
              "; ");
}

Table ParameterTable(const std::vector<ModelParameter>& parameters, double largest_rate_deg_s) {
  Table table{{{}, {"", kNumber}, {}, {"", kNote}}, {}};
  for (const ModelParameter& parameter : parameters) {
    const std::string unit = PrintedUnit(parameter);
    const double alone = parameter.statistical_std_error;
    const Text share = Number(ScaleAtRate(parameter.value, unit, largest_rate_deg_s));
    const Text statistical = alone < parameter.std_error
                                 ? Number("± " + FormatNumber(alone, 2)) + " of the fit alone"
                                 : Text();
    table.Add({parameter.name, Number(FormatMeasured(parameter.value, parameter.std_error)),
               Unit(unit), Join({share, statistical, parameter.because.value_or("")}, "; ")});
  }
  return table;
}

double LargestRate_deg_s(const ChannelTrace& channel) {
  double largest = kMissing;
  for (const double rate : channel.curves.rate_error_by_rate_deg_s.x)
    if (std::isfinite(rate)) largest = std::fmax(largest, std::fabs(rate));
  return largest;
}

std::string ScaleAtRate(double value, const std::string& unit, double rate_deg_s) {
  const int power = PowerOfRate(unit);
  const double share = value * std::pow(rate_deg_s, power);
  if (power == 0 || !std::isfinite(share) || !(rate_deg_s > 0.0)) return "";
  const bool percent = std::fabs(share) >= 1e-4;
  return fmt::format("{:.2g} {} at {:.3g} deg/s", share * (percent ? 1e2 : 1e6),
                     percent ? "%" : "ppm", rate_deg_s);
}

}  // namespace gyrobench::presentation
