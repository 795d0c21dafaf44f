#include <fmt/format.h>

#include <cmath>

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
  Markup figures = BigFigure("Angle error in windows of 10 s, on data held out",
                             channel.heldout_angle_rms_deg, "deg", has_effects);
  figures += BigFigure("The same as a forecast: trained on the first 60 % of the time",
                       channel.forecast_angle_rms_deg, "deg", has_effects);
  figures += BigFigure("Residual over noise, on data held out; the floor is 1",
                       channel.heldout_whitened_rms, "", has_effects);
  if (figures.empty()) {
    return Paragraph("There is no figure on held-out data.", "note");
  }
  return Element("div", figures, "figures");
}

// "A (the reference's), B or C".
Markup NamesOfEffects(const ChannelTrace& channel) {
  Markup names;
  for (const auto& effect : channel.effects) {
    if (!names.empty()) names += Markup::Text(", ");
    names += Code(effect.id);
    for (const std::string& rival : effect.rivals) names += Markup::Text(" or ") + Code(rival);
    if (effect.owner != calibration::EffectOwner::kGyro) {
      names += Markup::Text(fmt::format(" (the {}'s)", Name(effect.owner)));
    }
  }
  return names;
}

Markup Channel(const ChannelTrace& channel) {
  const VerdictWords words = WordsFor(channel.verdict);
  Markup head = Element("span", "Axis " + AxisName(channel.axis), "axis") +
                Element("span", fmt::format("{} {}", words.symbol, words.word), "word");
  Markup inside = Element("h2", head);
  inside += Paragraph(channel.summary.empty() ? words.sentence : channel.summary, "summary");
  if (!channel.effects.empty()) {
    inside += Element("p", Markup::Text("Found: ") + NamesOfEffects(channel), "found");
  }
  inside += Figures(channel);
  inside += BulletList(channel.remarks);
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
  if (!std::isfinite(low) || !std::isfinite(high)) return text + ", 95 % interval not estimated";
  // Of a growth the ends change sign and place. Unbreakable: the interval stays in one line.
  const double from = less ? low : -high, to = less ? high : -low;
  return fmt::format("{}, 95\u00A0%\u00A0interval\u00A0{}\u00A0to\u00A0{}", text,
                     FormatPercent(from), FormatPercent(to));
}

Markup VerdictSection(const calibration::TraceResult& trace) {
  Markup section;
  for (const ChannelTrace& channel : trace.channels) section += Channel(channel);
  if (trace.channels.empty()) {
    section += Paragraph("The trace has no channel: nothing could be estimated.", "summary");
  }
  return section + BulletList(trace.remarks);
}

}  // namespace gyrobench::report
