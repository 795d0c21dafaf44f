#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "report/number.h"
#include "report/sections.h"

namespace gyrobench::report {
namespace {

using calibration::ChannelTrace;
using calibration::HeldOut;
using calibration::Verdict;

struct VerdictWords {
  const char* symbol;  // told apart without colour
  const char* word;
  const char* css_class;
  const char* sentence;  // where the trace gives no summary of its own
};

VerdictWords WordsFor(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNone:
      return {"○", "Nothing beyond the baseline", "none",
              "The baseline accounts for all that is to be seen in these data."};
    case Verdict::kExplained:
      return {"●", "Explained", "explained",
              "The effects named below account for all that was left beyond the baseline."};
    case Verdict::kPartlyExplained:
      return {"◐", "Partly explained", "partly",
              "Effects were named, and structure remains beyond them."};
    case Verdict::kUnexplained:
      return {"?", "Unexplained", "unexplained",
              "Structure remains beyond the baseline, and no effect could be named for it."};
  }
  return {"?", "Unknown", "unexplained", ""};
}

// One figure, before and after; what the baseline alone gives where nothing was added to it.
Markup BigFigure(const std::string& title, HeldOut figure, const std::string& unit,
                 bool has_effects) {
  if (!std::isfinite(figure.before) && !std::isfinite(figure.after)) return {};
  if (!has_effects) figure.after = kMissing;
  Markup cell = Element("p", title, "what");
  cell += Element("p", BeforeAfter(figure, unit, unit.empty()), "figure");
  cell += Element("p", has_effects ? Reduction(figure) : "nothing was added", "interval");
  return Element("div", cell);
}

Markup Figures(const ChannelTrace& channel) {
  const bool has_effects = !channel.effects.empty();
  Markup figures = BigFigure(
      "Angle error in windows of 10 s, on data held out: effects chosen and fitted without them",
      channel.heldout_angle_rms_deg, "deg", has_effects);
  figures += BigFigure("The same as a forecast: all chosen on the first 60 % of the time",
                       channel.forecast_angle_rms_deg, "deg", has_effects);
  figures += BigFigure("Residual over noise, on data held out; 1 is as the noise explains",
                       channel.heldout_whitened_rms, "", has_effects);
  figures += BigFigure("Angle error on the data that all was chosen by and fitted to",
                       channel.fitted_angle_rms_deg, "deg", has_effects);
  if (figures.empty()) {
    return Paragraph("There is no figure on held-out data.", "note");
  }
  return Element("div", figures, "figures");
}

// "A (the reference's), B or C, D (4 times, the bench's)".
Markup NamesOfEffects(const ChannelTrace& channel) {
  Markup names;
  for (const EffectGroup& group : GroupById(channel)) {
    if (!names.empty()) names += Markup::Text(", ");
    names += Code(group.front()->id);
    std::set<std::string> rivals;
    for (const auto* effect : group) rivals.insert(effect->rivals.begin(), effect->rivals.end());
    for (const std::string& rival : rivals) names += Markup::Text(" or ") + Code(rival);
    std::string note = group.size() > 1 ? fmt::format("{} times", group.size()) : "";
    if (group.front()->owner != calibration::EffectOwner::kGyro)
      note += fmt::format("{}the {}'s", note.empty() ? "" : ", ", Name(group.front()->owner));
    if (!note.empty()) names += Markup::Text(fmt::format(" ({})", note));
  }
  return names;
}

VerdictWords WordsFor(const ChannelTrace& channel) {
  if (IsTraced(channel)) return WordsFor(channel.verdict);
  return {"–", "Not traced", "none",
          "This axis could not be traced with these data; the remarks say why."};
}

// The tracer's summary names the effects and the figures, which stand below where there are any.
std::string Sentence(const ChannelTrace& channel, const VerdictWords& words) {
  const bool figures = std::isfinite(channel.heldout_angle_rms_deg.before);
  const bool shown_below = !channel.effects.empty() && figures;
  return channel.summary.empty() || shown_below ? words.sentence : channel.summary;
}

// Remarks of a channel that do not hold for all of them.
std::vector<std::string> OwnRemarks(const ChannelTrace& channel,
                                    const std::vector<std::string>& shared) {
  std::vector<std::string> own;
  for (const std::string& remark : channel.remarks)
    if (std::find(shared.begin(), shared.end(), remark) == shared.end()) own.push_back(remark);
  return own;
}

std::vector<std::string> SharedRemarks(const calibration::TraceResult& trace) {
  std::vector<std::string> shared;
  if (trace.channels.size() < 2) return shared;
  for (const std::string& remark : trace.channels.front().remarks) {
    const bool all =
        std::all_of(trace.channels.begin(), trace.channels.end(), [&](const ChannelTrace& channel) {
          const auto& own = channel.remarks;
          return std::find(own.begin(), own.end(), remark) != own.end();
        });
    if (all) shared.push_back(remark);
  }
  return shared;
}

Markup Channel(const ChannelTrace& channel, const std::vector<std::string>& shared_remarks) {
  const VerdictWords words = WordsFor(channel);
  Markup head = Element("span", "Axis " + AxisName(channel.axis), "axis") +
                Element("span", fmt::format("{} {}", words.symbol, words.word), "word");
  Markup inside = Element("h2", head);
  inside += Paragraph(Sentence(channel, words), "summary");
  if (!channel.effects.empty()) {
    inside += Element("p", Markup::Text("Found: ") + NamesOfEffects(channel), "found");
  }
  inside += Figures(channel);
  inside += BulletList(OwnRemarks(channel, shared_remarks));
  return Element("section", inside, std::string("verdict ") + words.css_class);
}

}  // namespace

std::string BeforeAfter(const HeldOut& figure, const std::string& unit, bool ratio) {
  const auto format = [&](double value) {
    return ratio ? FormatRatio(value) : FormatNumber(value, 3);
  };
  std::string text = format(figure.before);
  if (std::isfinite(figure.after)) text += " → " + format(figure.after);
  return unit.empty() ? text : text + " " + unit;
}

std::string Reduction(const HeldOut& figure) {
  if (!std::isfinite(figure.after)) return "before; there is no figure for after";
  if (!std::isfinite(figure.before) || figure.before <= 0.0) return "no figure for before";
  const double share = 1.0 - figure.after / figure.before;
  const bool less = share >= 0.0;
  std::string text = std::abs(share) < 5e-4
                         ? "unchanged"
                         : FormatPercent(std::abs(share)) + (less ? " less" : " more");
  const auto [low, high] = figure.reduction_ci95;
  if (!std::isfinite(low) || !std::isfinite(high)) return text;
  // Of a growth the ends change sign and place. Unbreakable: the interval stays in one line.
  const double from = less ? low : -high, to = less ? high : -low;
  return fmt::format("{}, 95\u00A0%\u00A0interval\u00A0{}\u00A0to\u00A0{}", text,
                     FormatPercent(from), FormatPercent(to));
}

Markup VerdictSection(const calibration::TraceResult& trace) {
  Markup section;
  const std::vector<std::string> shared = SharedRemarks(trace);
  for (const ChannelTrace& channel : trace.channels) section += Channel(channel, shared);
  if (trace.channels.empty()) {
    section += Paragraph("The trace has no channel: nothing could be estimated.", "summary");
  }
  std::vector<std::string> remarks = shared;
  remarks.insert(remarks.end(), trace.remarks.begin(), trace.remarks.end());
  if (remarks.empty()) return section;
  return section +
         Element("section",
                 Element("h3", trace.channels.size() > 1 ? "Remarks on all axes" : "Remarks") +
                     BulletList(remarks),
                 "remarks");
}

}  // namespace gyrobench::report
