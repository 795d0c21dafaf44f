// A trace for a terminal, and the parts of a report on it.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::ChannelTrace;
using calibration::EffectOwner;
using calibration::ModelParameter;
using calibration::TraceResult;
using calibration::Verdict;

constexpr const char* kNominalFrame =
    "The matrix leads to the rate in the nominal frame of the sensor: on a stand that of the inner "
    "axis, turned by the configured mounting. The mounting here is what is left beyond that one: "
    "it rotates the sensor's vectors into the frame by Rz(z) Ry(y) Rx(x). Scale factors and "
    "non-orthogonality do not depend on it.";

// Behind a figure of held-out data.
std::string NotConfirmed(const ChannelTrace& channel) {
  return channel.heldout_angle_rms_deg.confirms_nothing() ? ", which does not confirm it" : "";
}

Paragraph Headline(const ChannelTrace& channel) {
  Text text = Strong(Capitalized(GyroName(channel.axis)) + ":") + " " + VerdictSentence(channel);
  const std::string angle = BeforeAfter(channel.heldout_angle_rms_deg, FormatFigure);
  if (!channel.effects.empty() && angle != "-" && channel.verdict != Verdict::kCannotBe)
    text += "; angle error of held-out data " + Quantity(angle, "deg") + NotConfirmed(channel);
  return {text};
}

Section BaselineSection(const ChannelTrace& channel) {
  Section section{"Baseline", {}};
  Add(section.blocks, ParameterTable(channel.baseline.parameters, kMissing));
  if (!section.blocks.empty()) Add(section.blocks, OffsetNote(channel));
  return section;
}

Section FiguresSection(const ChannelTrace& channel) {
  return {"Figures", ErrorBlocks(channel), ""};
}

Section ChannelSection(const ChannelTrace& channel, double duration_s) {
  Section section{Capitalized(GyroName(channel.axis)), {}};
  Document& blocks = section.blocks;
  const std::vector<EffectGroup> groups = GroupById(channel);
  Add(blocks, GainTable(groups));
  Add(blocks, ExplainGains(groups));
  for (const EffectGroup& group : groups) {
    Add(blocks,
        Section{Code(group.front()->id) + Whose(*group.front()) + ": " + AboutEffects(group),
                EffectBlocks(group, LargestRate_deg_s(channel)), ""});
  }
  Add(blocks, BaselineSection(channel));
  Add(blocks, FiguresSection(channel));
  Section noise{"Noise", {}};
  Add(noise.blocks, NoiseTable(channel.noise, duration_s));
  Add(blocks, std::move(noise));
  Add(blocks, Section{"What remains", RemainingBlocks(channel), ""});
  return section;
}

Document Inputs(const TraceResult& trace) {
  Document document;
  for (const calibration::TraceInput& input : trace.inputs) {
    std::vector<std::string> defects;
    for (const Defect& defect : input.defects) {
      std::string at = std::isfinite(defect.first_t_s)
                           ? fmt::format(", first at {:.3f} s", defect.first_t_s)
                           : "";
      if (!defect.where.empty()) at += (at.empty() ? ", first " : ", ") + defect.where;
      defects.push_back(fmt::format("{} {}{}", FormatCount(defect.count), defect.kind, at));
    }
    Add(document, Paragraph{fmt::format(
                      "{}{}{} samples in {}; {}", input.file, input.file.empty() ? "" : ": ",
                      FormatCount(input.samples), FormatDuration(input.duration_s),
                      defects.empty() ? "no defects"
                                      : fmt::format("defects: {}", fmt::join(defects, "; ")))});
  }
  return document;
}

Paragraph ReferenceNote(const TraceResult& trace) {
  if (trace.reference_error.empty()) return {};
  return {"reference: " + trace.reference_error, "note"};
}

// How a verdict looks on a page, told apart without colour, and its sentence where the trace gives
// none.
struct VerdictLook {
  const char *symbol, *role, *sentence;
};
VerdictLook LookOf(const ChannelTrace& channel) {
  if (!IsTraced(channel))
    return {"–", "none", "This axis could not be traced with these data; the remarks say why."};
  switch (channel.verdict) {
    case Verdict::kNone:
      return {"○", "none", "The baseline accounts for all that is to be seen in these data."};
    case Verdict::kExplained:
      return {"●", "explained",
              "The effects named below account for all that was left beyond the baseline."};
    case Verdict::kPartlyExplained:
      return {"◐", "partly", "Effects were named, and structure remains beyond them."};
    case Verdict::kCannotBe:
      return {"✗", "cannot-be", "These data contradict each other; nothing here is a result."};
    case Verdict::kUnexplained:
      break;
  }
  return {"?", "unexplained",
          "Structure remains beyond the baseline, and no effect could be named for it."};
}

// The tracer's summary names the effects and the figures, which stand below where there are any.
std::string Sentence(const ChannelTrace& channel, const VerdictLook& look) {
  const bool figures = std::isfinite(channel.heldout_angle_rms_deg.before);
  const bool shown_below =
      !channel.effects.empty() && figures && channel.verdict != Verdict::kCannotBe;
  return channel.summary.empty() || shown_below ? look.sentence : channel.summary;
}

Section VerdictCard(const ChannelTrace& channel) {
  const VerdictLook look = LookOf(channel);
  const std::string words =
      IsTraced(channel) ? VerdictWords(Name(channel.verdict)) : std::string("not traced");
  Section card{Strong(Capitalized(GyroName(channel.axis))) +
                   fmt::format("{} {}", look.symbol, Capitalized(words)),
               {},
               std::string("verdict ") + look.role};
  Add(card.blocks, Paragraph{Sentence(channel, look), "summary"});
  if (!channel.effects.empty() && channel.verdict != Verdict::kCannotBe) {
    Add(card.blocks, Paragraph{"Found: " + NamesOfEffects(channel, true), "found"});
    if (channel.heldout_angle_rms_deg.confirms_nothing())
      Add(card.blocks, Paragraph{"Data that the choice never saw do not confirm this: their error "
                                 "does not fall."});
  }
  Document errors = ErrorBlocks(channel);
  if (errors.empty()) Add(errors, Paragraph{"There is no figure on held-out data.", "note"});
  Add(card.blocks, std::move(errors));
  return card;
}

void AddParameters(Table& table, const Text& group, const std::vector<ModelParameter>& parameters,
                   double largest_rate_deg_s) {
  if (parameters.empty()) return;
  table.rows.push_back({{group}, true});
  const Table plain = ParameterTable(parameters, largest_rate_deg_s);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const ModelParameter& parameter = parameters[i];
    const bool apart = std::isfinite(parameter.statistical_std_error);
    const double error = apart ? parameter.statistical_std_error : parameter.std_error;
    std::vector<Text> cells = plain.rows[i].cells;
    cells.insert(cells.begin() + 3, {Number(FormatNumber(parameter.bound, 2)),
                                     Number(FormatRatio(error / parameter.bound))});
    table.Add(std::move(cells));
  }
}

// Whether an error contains what the fit does not know of.
bool HasMoreThanTheFits(const TraceResult& trace) {
  const auto has = [](const std::vector<ModelParameter>& parameters) {
    return std::ranges::any_of(parameters, [](const ModelParameter& parameter) {
      return std::isfinite(parameter.statistical_std_error);
    });
  };
  return std::ranges::any_of(trace.channels, [&](const ChannelTrace& channel) {
    return has(channel.baseline.parameters) ||
           std::ranges::any_of(channel.effects, has, &calibration::TracedEffect::parameters);
  });
}

Section ParameterSection(const TraceResult& trace) {
  Section section{"Parameters", {}};
  for (const ChannelTrace& channel : trace.channels) {
    Table table{{{"Parameter"},
                 {"Value ± standard error", kNumber},
                 {"Unit"},
                 {"Cramér-Rao bound", kNumber},
                 {"Error / bound", kNumber},
                 {""}},
                {}};
    AddParameters(table, "Baseline", channel.baseline.parameters, kMissing);
    for (const EffectGroup& group : GroupById(channel)) {
      for (std::size_t i = 0; i < group.size(); ++i) {
        const std::string which =
            group.size() == 1 ? "" : fmt::format(", {} of {}", i + 1, group.size());
        AddParameters(table, Code(group[i]->id) + (which + Whose(*group[i])), group[i]->parameters,
                      LargestRate_deg_s(channel));
      }
    }
    Section axis{Capitalized(GyroName(channel.axis)), {}, "short"};
    Add(axis.blocks, std::move(table));
    if (!channel.baseline.parameters.empty()) Add(axis.blocks, OffsetNote(channel));
    Add(section.blocks, std::move(axis));
  }
  if (section.blocks.empty()) Add(section.blocks, Paragraph{"No parameter could be estimated."});
  Add(section.blocks, ReferenceNote(trace));
  if (HasMoreThanTheFits(trace))
    Add(section.blocks, Paragraph{"The ratio of error to bound is that of the fit alone.", "note"});
  return section;
}

Section EffectCard(const ChannelTrace& channel, const EffectGroup& group) {
  Text title = Strong(Capitalized(GyroName(channel.axis))) + Code(group.front()->id);
  if (group.size() > 1) title += fmt::format(", {} times", group.size());
  Section card{std::move(title), {}};
  Add(card.blocks, Paragraph{AboutEffects(group)});
  Add(card.blocks, GainTable({group}));
  Add(card.blocks, EffectBlocks(group, LargestRate_deg_s(channel)));
  return card;
}

Section EffectsOf(const TraceResult& trace, EffectOwner owner) {
  Section section;
  section.title = owner == EffectOwner::kGyro
                      ? "The gyro's own: the calibration corrects them"
                      : fmt::format(
                            "The {}'s: errors of the comparison, not corrected in the "
                            "sensor",
                            Name(owner));
  for (const ChannelTrace& channel : trace.channels) {
    for (const EffectGroup& group : GroupById(channel))
      if (group.front()->owner == owner) Add(section.blocks, EffectCard(channel, group));
  }
  return section;
}

std::vector<EffectGroup> AllGroups(const TraceResult& trace) {
  std::vector<EffectGroup> all;
  for (const ChannelTrace& channel : trace.channels)
    for (EffectGroup& group : GroupById(channel)) all.push_back(std::move(group));
  return all;
}

Section EffectSection(const TraceResult& trace) {
  Section gyro = EffectsOf(trace, EffectOwner::kGyro);
  Document others;
  Add(others, EffectsOf(trace, EffectOwner::kReference));
  Add(others, EffectsOf(trace, EffectOwner::kBench));
  Section section{"Effects, and whose they are", {}};
  if (gyro.blocks.empty() && others.empty()) {
    section.title = "Effects";
    Add(section.blocks, Paragraph{"No effect was added to the baseline."});
    return section;
  }
  Add(section.blocks, ExplainGains(AllGroups(trace)));
  const Paragraph note =
      gyro.blocks.empty()
          ? Paragraph{"None. The calibration corrects the baseline alone."}
          : Paragraph{
                "But for what no correction sample by sample can undo: a lag, a step or a "
                "tone of this run, the Earth's rotation.",
                "note"};
  gyro.blocks.insert(gyro.blocks.begin(), {note});
  Add(section.blocks, std::move(gyro));
  Add(section.blocks, std::move(others));
  return section;
}

Section RivalSection(const TraceResult& trace) {
  Facts facts;
  bool named = false;
  for (const ChannelTrace& channel : trace.channels) {
    for (const calibration::TracedEffect& effect : channel.effects) {
      named = true;
      facts.Add(Capitalized(GyroName(channel.axis)) + ", " + Code(effect.id), RivalsText(effect));
    }
  }
  Section section{"Rivals", {}, "short"};
  Add(section.blocks, facts);
  if (named && facts.facts.empty()) {
    Add(section.blocks, Paragraph{"None: these data tell each effect that was named from all "
                                  "others of the catalogue."});
  }
  return section;
}

Section RemainingSection(const TraceResult& trace) {
  Section section{"What remains", {}, "short"};
  for (const ChannelTrace& channel : trace.channels)
    Add(section.blocks, Section{Capitalized(GyroName(channel.axis)), RemainingBlocks(channel), ""});
  return section;
}

}  // namespace

Document TraceDocument(const TraceResult& trace) {
  Document document;
  for (const ChannelTrace& channel : trace.channels) Add(document, Headline(channel));
  for (const ChannelTrace& channel : trace.channels)
    Add(document, ChannelSection(channel, LongestDuration_s(trace)));
  Add(document, VectorSection(trace.vector, kNominalFrame));
  Section reference{"Reference", {}};
  Add(reference.blocks, Paragraph{trace.reference_error});
  Add(document, std::move(reference));
  Add(document, UnseenSection(trace));
  Add(document, Inputs(trace));
  Add(document, TraceRemarks(trace));
  return document;
}

Document TraceSummary(const TraceResult& trace, const std::vector<std::string>& not_known) {
  Section section{"Trace", {}};
  for (const ChannelTrace& channel : trace.channels)
    Add(section.blocks, Paragraph{GyroName(channel.axis) + ": " + VerdictSentence(channel)});
  List unread = ListOf(not_known);
  unread.marker = "! ";
  Add(section.blocks, std::move(unread));
  Document document;
  Add(document, std::move(section));
  return document;
}

Document TracePage(const TraceResult& trace) {
  Document page;
  for (const ChannelTrace& channel : trace.channels) Add(page, VerdictCard(channel));
  if (trace.channels.empty()) {
    Add(page, Paragraph{"The trace has no channel: nothing could be estimated.", "summary"});
  }
  Section remarks{"Remarks", {}, "remarks"};
  Add(remarks.blocks, TraceRemarks(trace));
  Add(page, std::move(remarks));
  for (const ChannelTrace& channel : trace.channels) Add(page, ResidualCharts(channel));
  Add(page, ParameterSection(trace));
  Add(page, VectorSection(trace.vector, kNominalFrame));
  Add(page, EffectSection(trace));
  Add(page, RivalSection(trace));
  Section unseen = UnseenSection(trace);
  if (unseen.blocks.empty() && !trace.channels.empty())
    Add(unseen.blocks, Paragraph{"Nothing: every effect of the catalogue would have shown."});
  Add(page, std::move(unseen));
  Add(page, RemainingSection(trace));
  return page;
}

Document NoisePage(const TraceResult& trace) {
  Section section{"Noise", {}, "short"};
  for (const ChannelTrace& channel : trace.channels) {
    Section axis{Capitalized(GyroName(channel.axis)), {}};
    Add(axis.blocks, NoiseTable(channel.noise, LongestDuration_s(trace)));
    Add(section.blocks, std::move(axis));
  }
  if (!section.blocks.empty())
    Add(section.blocks,
        Paragraph{"By restricted maximum likelihood, of all data and the model with the effects; "
                  "each of the baseline estimates has a noise of its own, of its own fit. Not "
                  "seen: below what these data could show.",
                  "note"});
  Document page;
  Add(page, std::move(section));
  return page;
}

}  // namespace gyrobench::presentation
