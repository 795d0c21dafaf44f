#include "cli/effect_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cli/json_field.h"
#include "cli/number_text.h"
#include "report/reason.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Rows = std::vector<std::vector<std::string>>;
// Effects of one id, in the order in which they were found.
using Group = std::vector<const Json*>;

std::vector<Group> GroupById(const Json& effects) {
  std::vector<Group> groups;
  for (const Json& effect : effects) {
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
      return Text(*group.front(), "id") == Text(effect, "id");
    });
    if (same == groups.end()) {
      groups.push_back({&effect});
    } else {
      same->push_back(&effect);
    }
  }
  return groups;
}

// "(2) ", and nothing where there is but one.
std::string Ordinal(const Group& group, std::size_t i) {
  return group.size() == 1 ? "" : fmt::format("({}) ", i + 1);
}

// The field's text where all have the same, else empty.
std::string Shared(const Group& group, const std::string& key) {
  const std::string first = Text(*group.front(), key);
  const bool all = std::all_of(group.begin(), group.end(),
                               [&](const Json* effect) { return Text(*effect, key) == first; });
  return all ? first : "";
}

// To three digits, zeros kept: figures that are compared.
std::string Figure(double value) {
  if (!std::isfinite(value)) return "-";
  std::string text = fmt::format("{:#.3g}", value);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string Owner(const Json& effect) {
  const std::string owner = Text(effect, "owner");
  return owner.empty() ? "gyro" : owner;
}

bool ChosenOnAllData(const Json& effect) { return Text(effect, "chosen_on") == "all_data"; }

std::string GainTable(const std::vector<Group>& groups, const Terminal& terminal) {
  Rows rows = {{"effect, without → with", "of", "angle error, deg", "whitened rms", "chance"}};
  for (const Group& group : groups) {
    for (std::size_t i = 0; i < group.size(); ++i) {
      const Json& effect = *group[i];
      const char* mark = ChosenOnAllData(effect) ? " *" : "";
      rows.push_back({Ordinal(group, i) + Text(effect, "id") + mark, Owner(effect),
                      BeforeAfter(Field(effect, "heldout_angle_rms_deg")),
                      BeforeAfter(Field(effect, "heldout_whitened_rms")),
                      PValue(Number(effect, "p_value"))});
    }
  }
  return FitLines(AlignColumns(rows, std::vector<Align>(5, Align::kLeft), 2), terminal);
}

std::string ParameterValue(const Json& parameter) {
  return FormatMeasured(Number(parameter, "value"), Number(parameter, "std_error"));
}

std::string UnitOf(const Json& parameter) {
  const std::string unit = Text(parameter, "unit");
  return unit == "1" ? "" : unit;
}

std::vector<std::string> ParameterHeads(const Json& effect) {
  std::vector<std::string> heads;
  for (const Json& parameter : Field(effect, "parameters")) {
    const std::string unit = UnitOf(parameter);
    heads.push_back(Text(parameter, "name") + (unit.empty() ? "" : ", " + unit));
  }
  return heads;
}

// One line an effect, one column a parameter.
std::string ParameterTable(const Group& group, const Terminal& terminal) {
  Rows rows = {{""}};
  for (const std::string& head : ParameterHeads(*group.front())) rows.front().push_back(head);
  for (std::size_t i = 0; i < group.size(); ++i) {
    rows.push_back({fmt::format("({})", i + 1)});
    for (const Json& parameter : Field(*group[i], "parameters"))
      rows.back().push_back(ParameterValue(parameter));
  }
  return FitLines(AlignColumns(rows, std::vector<Align>(rows.front().size(), Align::kLeft), 4),
                  terminal);
}

std::string GroupParameters(const Group& group, const Terminal& terminal,
                            double largest_rate_deg_s) {
  const bool alike = std::all_of(group.begin(), group.end(), [&](const Json* effect) {
    return ParameterHeads(*effect) == ParameterHeads(*group.front());
  });
  if (group.size() > 1 && alike) return ParameterTable(group, terminal);
  std::string text;
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group.size() > 1) text += "    " + Ordinal(group, i) + "\n";
    text += ParametersText(Field(*group[i], "parameters"), terminal, largest_rate_deg_s);
  }
  return text;
}

std::vector<std::string> Rivals(const Json& effect) {
  std::vector<std::string> texts;
  for (const Json& rival : Field(effect, "rivals")) texts.push_back(Plain(rival));
  return texts;
}

std::string RivalsText(const Group& group, const Terminal& terminal) {
  std::string text;
  for (std::size_t i = 0; i < group.size(); ++i) {
    const std::vector<std::string> rivals = Rivals(*group[i]);
    std::string line;
    if (!rivals.empty())
      line = fmt::format("or {}: these data cannot tell", fmt::join(rivals, ", or "));
    if (const std::string by = Text(*group[i], "settled_by"); !by.empty())
      line += (line.empty() ? "settled by: " : "; settled by: ") + by;
    if (!line.empty()) text += Paragraph(Ordinal(group, i) + line, terminal, 4);
  }
  return text;
}

std::string GroupText(const Group& group, const Terminal& terminal, double largest_rate_deg_s) {
  std::string head = Text(*group.front(), "id");
  const std::string equation = Shared(group, "equation"), cause = Shared(group, "cause");
  if (!equation.empty()) head += ": " + equation;
  if (!cause.empty()) head += (equation.empty() ? ": " : "; ") + cause;
  std::string text = Paragraph(head, terminal, 2);
  for (std::size_t i = 0; equation.empty() && i < group.size(); ++i) {
    if (const std::string own = Text(*group[i], "equation"); !own.empty())
      text += Paragraph(Ordinal(group, i) + own, terminal, 4);
  }
  return text + GroupParameters(group, terminal, largest_rate_deg_s) + RivalsText(group, terminal);
}

}  // namespace

std::string Paragraph(const std::string& text, const Terminal& terminal, int indent) {
  const int columns =
      terminal.is_terminal ? std::min(terminal.columns, kTextColumns) : kTextColumns;
  return std::string(static_cast<std::size_t>(indent), ' ') +
         Wrap(text, columns - indent, indent + 2) + "\n";
}

std::string BeforeAfter(const Json& held_out) {
  const double before = Number(held_out, "before"), after = Number(held_out, "after");
  if (!std::isfinite(before) && !std::isfinite(after)) return "-";
  return Figure(before) + " → " + Figure(after);
}

std::string PValue(double p) {
  if (!std::isfinite(p)) return "p not known";
  return p < 1e-16 ? "p < 1e-16" : fmt::format("p = {:.2g}", p);
}

std::string NamesOfEffects(const Json& effects) {
  std::vector<std::pair<std::string, int>> names;
  for (const Json& effect : effects) {
    std::vector<std::string> one = Rivals(effect);
    one.insert(one.begin(), Text(effect, "id"));
    const std::string name = fmt::format("{}", fmt::join(one, " or "));
    const auto same = std::find_if(names.begin(), names.end(),
                                   [&](const auto& other) { return other.first == name; });
    if (same == names.end()) {
      names.emplace_back(name, 1);
    } else {
      ++same->second;
    }
  }
  // "a, b or c" would leave open what belongs together.
  const bool rivals = std::any_of(names.begin(), names.end(), [](const auto& one) {
    return one.first.find(" or ") != std::string::npos;
  });
  std::string text;
  for (const auto& [name, times] : names) {
    text += (text.empty() ? "" : rivals ? "; " : ", ") + name;
    if (times > 1) text += fmt::format(" ({} times)", times);
  }
  return text;
}

std::string EffectsText(const Json& effects, const Terminal& terminal, double largest_rate_deg_s) {
  if (!effects.is_array() || effects.empty()) return "";
  const std::vector<Group> groups = GroupById(effects);
  std::string text = GainTable(groups, terminal);
  if (std::any_of(effects.begin(), effects.end(), ChosenOnAllData)) {
    text += Paragraph(
        "* found in all data, but not in the two thirds of them that are then tried on the rest, "
        "or "
        "there are too few data for that. Its figures compare all that is named with the same "
        "without it; all data had a part in choosing it, so that they are no independent test, and "
        "not to be compared with those of a row without the mark.",
        terminal, 2);
  }
  text += "\n";
  for (const Group& group : groups) text += GroupText(group, terminal, largest_rate_deg_s);
  return text;
}

std::string ParametersText(const Json& parameters, const Terminal& terminal,
                           double largest_rate_deg_s) {
  Rows rows;
  for (const Json& parameter : parameters) {
    const std::string unit = UnitOf(parameter);
    std::string note = report::ScaleAtRate(Number(parameter, "value"), unit, largest_rate_deg_s);
    const double alone = Number(parameter, "statistical_std_error");
    if (alone < Number(parameter, "std_error"))
      note += fmt::format("{}± {} without the reference's own error", note.empty() ? "" : "; ",
                          FormatNumber(alone, 2));
    rows.push_back({Text(parameter, "name"), ParameterValue(parameter), unit, note});
  }
  return FitLines(AlignColumns(rows, std::vector<Align>(4, Align::kLeft), 4), terminal);
}

}  // namespace gyrobench::cli
