// The catalogue of effects, as a list, one by one, or as a page.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "base/json_text.h"
#include "base/nearest_word.h"
#include "calibration/artefact/calibration_file.h"
#include "calibration/effects/effect.h"
#include "calibration/plan/effect_picture.h"
#include "cli/commands.h"
#include "cli/exit_status.h"
#include "presentation/document.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

using calibration::Effect;
using calibration::EffectGallery;
using calibration::NeverSeen;
using OrderedJson = nlohmann::ordered_json;
// Of the equations.
constexpr const char* kSymbols =
    "w: rate about the axis; g: specific force in g; T: temperature, T0: that from which it is "
    "counted; t: time; phi: angle of the table; psi: angle of the shaft; x: the column; P_r[T]: T "
    "through a play of r either way; 1(...): 1 where it holds, else 0; w_E: rate of the Earth. The "
    "angle is the gyro's less the reference's: an error "
    "of the reference itself has the opposite sign.";

// Of the pictures; EffectGallery.
constexpr const char* kTypicalRun =
    "Each picture is the residual of the baseline without noise, with the effect at its largest "
    "usual size (1 where that is not known), in a run made for it: z up, horizontal and down, the "
    "table rests and turns by 360 deg there and back at 6 to 36 deg/s while the temperature goes "
    "from 25 to 40 degC, and all of that once more while it falls. The vibration of the stand is "
    "largest at 18 deg/s. Where such a run is all there is, an effect is hard to tell from those "
    "that describe nine tenths of its picture (of its sum of squares).";

using Facts = std::vector<std::pair<std::string, std::string>>;  // what, and what is said of it

std::string NeedsText(unsigned needs) {
  constexpr std::pair<unsigned, const char*> kNames[] = {
      {calibration::kNeedsRate, "motion about the axis, by a reference"},
      {calibration::kNeedsGravity, "gravity in the sensor's frame"},
      {calibration::kNeedsTemperature, "a temperature that changes"},
      {calibration::kNeedsTableAxis, "the angle of a table"},
      {calibration::kNeedsCovariate, "a column of its own"},
      {calibration::kNeedsVibration, "an accelerometer that feels vibration"},
      {calibration::kNeedsPowerOn, "when the sensor was switched on"},
      {calibration::kNeedsGear, "the gear between shaft and table"}};
  std::vector<std::string> parts;
  for (const auto& [need, name] : kNames) {
    if ((needs & need) != 0) parts.emplace_back(name);
  }
  return parts.empty() ? "nothing but the output" : fmt::format("{}", fmt::join(parts, "; "));
}

std::string SizeText(const Effect& effect) {
  if (!(effect.typical_size > 0.0)) return "not known";
  return fmt::format("{:g} {}", effect.typical_size, effect.terms[0].unit);
}

std::string TermsText(const Effect& effect) {
  std::vector<std::string> parts;
  for (const calibration::EffectTerm& term : effect.terms)
    parts.push_back(fmt::format("{} [{}]", term.name, term.unit));
  for (const calibration::NonlinearParameter& parameter : effect.nonlinear) {
    if (effect.search == calibration::Search::kCoefficient) continue;
    std::string range;
    if (parameter.high > parameter.low)
      range = fmt::format(", {:g} to {:g}", parameter.low, parameter.high);
    parts.push_back(fmt::format("{} [{}{}]", parameter.name, parameter.unit, range));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

std::string CorrectionText(const Effect& effect) {
  calibration::ModelTerm term;
  term.id = effect.id;
  term.owner = effect.owner;
  term.nonlinear.assign(effect.nonlinear.size(), 0.0);
  if (const std::string why_not = WhyNotApplied(term); !why_not.empty()) return "no: " + why_not;
  return effect.c_expression.empty() ? "by gyrobench apply"
                                     : "by gyrobench apply and in exported C";
}

std::string RivalsText(const Effect& effect, const EffectGallery& gallery) {
  const std::vector<std::string> rivals = gallery.RivalsOf(effect);
  return rivals.empty() ? "none of the catalogue" : fmt::format("{}", fmt::join(rivals, ", "));
}

std::string PictureText(const Effect& effect, const EffectGallery& gallery) {
  calibration::EffectPicture picture = gallery.PictureOf(effect);
  return presentation::DrawPoints({std::move(picture.x_label), std::move(picture.y_label),
                                   std::move(picture.x), std::move(picture.y)});
}
std::string PictureText(const NeverSeen&, const EffectGallery&) { return ""; }

Facts FactsOf(const Effect& effect, const EffectGallery& gallery) {
  const bool angle = effect.domain == calibration::EffectDomain::kAngle;
  Facts facts = {{angle ? "adds to the angle" : "adds to the rate", effect.equation},
                 {"parameters", TermsText(effect)},
                 {"looks like", effect.looks_like},
                 {"cause", effect.cause},
                 {"belongs to", Name(effect.owner)},
                 {"largest size", SizeText(effect)}};
  if (!effect.size_source.empty()) facts.back().second += "; " + effect.size_source;
  facts.emplace_back("hard to tell from", RivalsText(effect, gallery));
  facts.emplace_back("must be known", NeedsText(effect.needs));
  facts.emplace_back("to show it", ManoeuvreFor(effect));
  facts.emplace_back("is corrected", CorrectionText(effect));
  return facts;
}

Facts FactsOf(const NeverSeen& effect, const EffectGallery&) {
  return {{"cannot be seen", effect.because}, {"to show it", effect.settled_by}};
}

std::string FactsText(const std::string& id, const Facts& facts,
                      const presentation::Terminal& terminal) {
  std::size_t width = 0;
  for (const auto& [what, says] : facts) width = std::max(width, what.size());
  std::string text = terminal.Bold(id) + "\n";
  for (const auto& [what, says] : facts) {
    const std::string line = fmt::format("{:<{}}  {}", what, width, says);
    text += presentation::Wrap(line, terminal.columns, static_cast<int>(width) + 2) + "\n";
  }
  return text;
}

std::string MarkdownText(const Facts& facts, const std::string& picture) {
  std::string text = "\n| | |\n|---|---|\n";
  for (const auto& [what, says] : facts) {
    std::string cell;
    for (const char c : says) cell += c == '|' ? std::string("\\|") : std::string(1, c);
    text += fmt::format("| {} | {} |\n", what, cell);
  }
  if (!picture.empty()) text += fmt::format("\n```\n{}```\n", picture);
  return text;
}

OrderedJson ToJson(const Effect& effect, const EffectGallery& gallery) {
  OrderedJson parameters = OrderedJson::array();
  for (const calibration::EffectTerm& term : effect.terms)
    parameters.push_back({{"name", term.name}, {"unit", term.unit}});
  for (const calibration::NonlinearParameter& parameter : effect.nonlinear) {
    if (effect.search == calibration::Search::kCoefficient) continue;
    OrderedJson one = {{"name", parameter.name}, {"unit", parameter.unit}};
    if (parameter.high > parameter.low)
      one.update({{"low", parameter.low}, {"high", parameter.high}});
    parameters.push_back(std::move(one));
  }
  const bool angle = effect.domain == calibration::EffectDomain::kAngle;
  OrderedJson size;
  if (effect.typical_size > 0.0)
    size = {{"value", effect.typical_size}, {"unit", effect.terms[0].unit}};
  return {{"id", effect.id},
          {"owner", Name(effect.owner)},
          {"adds_to", angle ? "angle" : "rate"},
          {"equation", effect.equation},
          {"parameters", parameters},
          {"looks_like", effect.looks_like},
          {"cause", effect.cause},
          {"largest_size", size},
          {"size_source", effect.size_source},
          {"rivals", gallery.RivalsOf(effect)},
          {"must_be_known", NeedsText(effect.needs)},
          {"to_show_it", ManoeuvreFor(effect)},
          {"is_corrected", CorrectionText(effect)}};
}

OrderedJson ToJson(const NeverSeen& effect, const EffectGallery&) {
  return {{"id", effect.id},
          {"owner", nullptr},
          {"parameters", OrderedJson::array()},
          {"rivals", OrderedJson::array()},
          {"cannot_be_seen_because", effect.because},
          {"to_show_it", effect.settled_by}};
}

// Of the effect `id`, or of all where it is empty.
template <typename Do>
void ForEach(const std::string& id, Do&& act) {
  bool any = false;
  std::vector<std::string> known;
  const auto pass = [&](const auto& effect) {
    if (known.empty() || known.back() != effect.id) known.push_back(effect.id);
    if (!id.empty() && effect.id != calibration::CatalogueName(id)) return;
    act(effect);
    any = true;
  };
  for (const Effect& effect : calibration::EffectCatalogue()) pass(effect);
  for (const NeverSeen& effect : calibration::NeverSeenEffects()) pass(effect);
  if (any) return;
  if (id.starts_with("composed(") || id.starts_with("empirical(")) {
    throw UsageError(fmt::format(
        "\"{}\" is no effect of the catalogue: a trace describes what none of them explains by a "
        "product of two quantities, composed(...), or by a curve of one, empirical(...), whose "
        "cause is not known",
        id));
  }
  throw UsageError(fmt::format("no effect \"{}\" in the catalogue; {}", id, Suggestion(id, known)));
}

std::string ListText(const presentation::Terminal& terminal) {
  presentation::Table table{{{"effect"}, {"of"}, {"equation", presentation::Column::Kind::kNote}},
                            {}};
  for (const Effect& effect : calibration::EffectCatalogue())
    table.Add({effect.id, Name(effect.owner), effect.equation});
  for (const NeverSeen& effect : calibration::NeverSeenEffects())
    table.Add({effect.id, "", "cannot be seen with one reference and one clock"});
  return presentation::RenderText({{std::move(table)}}, terminal);
}

OrderedJson JsonList(const std::string& id) {
  const EffectGallery gallery;
  OrderedJson list = OrderedJson::array();
  ForEach(id, [&](const auto& effect) { list.push_back(ToJson(effect, gallery)); });
  return list;
}

// An effect that has several forms is one section.
void PrintPage(const std::string& id) {
  fmt::print("# The effects that gyrobench looks for\n\n{}\n\n{}\n", kSymbols, kTypicalRun);
  const EffectGallery gallery;
  std::string last;
  ForEach(id, [&](const auto& effect) {
    if (effect.id != last) fmt::print("\n## `{}`\n", effect.id);
    last = effect.id;
    fmt::print("{}", MarkdownText(FactsOf(effect, gallery), PictureText(effect, gallery)));
  });
}

void PrintText(const std::string& id, const presentation::Terminal& terminal) {
  using presentation::FitLines, presentation::Wrap;
  if (id.empty()) {
    fmt::print(
        "{}\n{}\ngyrobench effects ID says what it looks like, its cause, and what shows it.\n",
        ListText(terminal), Wrap(kSymbols, terminal.columns, 0));
    return;
  }
  const EffectGallery gallery;
  ForEach(id, [&](const auto& effect) {
    fmt::print("{}", FactsText(effect.id, FactsOf(effect, gallery), terminal));
    const std::string picture = PictureText(effect, gallery);
    if (!picture.empty()) fmt::print("\n{}\n", FitLines(picture, terminal));
  });
  fmt::print("{}\n\n{}\n", Wrap(kSymbols, terminal.columns, 0),
             Wrap(kTypicalRun, terminal.columns, 0));
}

}  // namespace

int Effects(const Options& options) {
  ForEach(options.name, [](const auto&) {});  // says so at once where there is none of that name
  if (options.json) {
    fmt::print("{}\n", JsonText(OrderedJson{{"format", "gyrobench.effects/1"},
                                            {"effects", JsonList(options.name)}},
                                2));
    return kDone;
  }
  if (options.markdown) {
    PrintPage(options.name);
  } else {
    PrintText(options.name, presentation::DescribeTerminal(fileno(stdout)));
  }
  return kDone;
}

}  // namespace gyrobench::cli
