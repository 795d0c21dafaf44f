#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "calibration/effects/effect.h"
#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::ChannelTrace;
using calibration::HeldOut;
using calibration::Verdict;

// A sentence as a part of another one.
std::string Clause(std::string sentence) {
  if (sentence.ends_with('.')) sentence.pop_back();
  if (!sentence.empty())
    sentence.front() =
        static_cast<char>(std::tolower(static_cast<unsigned char>(sentence.front())));
  return sentence;
}

// Only what is known of before or after.
void AddFigure(Comparisons& errors, const std::string& name, const HeldOut& figure,
               const std::string& unit, const Text& note) {
  if (!std::isfinite(figure.before) && !std::isfinite(figure.after)) return;
  errors.figures.push_back({name,
                            Number(BeforeAfter(figure, unit.empty() ? FormatRatio : FormatFigure)),
                            Reduction(figure), unit, note});
}

// Where nothing was added there is nothing after it.
HeldOut Before(const HeldOut& figure) { return {figure.before, kMissing, {kMissing, kMissing}}; }

// "73.7 % less"; a share below 0 is a growth.
Text Change(double share) {
  return Number(FormatPercent(std::fabs(share))) + (share < 0.0 ? " more" : " less");
}

std::string FindingText(const calibration::Finding& finding) {
  if (!finding.says.empty()) return finding.says;
  return finding.covariate.empty() ? finding.test : finding.test + " against " + finding.covariate;
}

// Error and whitened residual, held out, forecast and of all data.
Comparisons ErrorsOf(const ChannelTrace& channel) {
  const bool added = !channel.effects.empty();
  const auto shown = [&](const HeldOut& figure) { return added ? figure : Before(figure); };
  const Text windows = "windows of " + Quantity("10", "s") + ", ";
  constexpr const char* kWhite = "1: as the noise explains";
  Comparisons errors;
  AddFigure(errors, "angle error, held out", shown(channel.heldout_angle_rms_deg), "deg",
            windows + "effects chosen and fitted without them");
  AddFigure(errors, "whitened rms, held out", shown(channel.heldout_whitened_rms), "", kWhite);
  AddFigure(errors, "angle error, forecast", shown(channel.forecast_angle_rms_deg), "deg",
            windows + "all chosen and fitted on the first " + Number("60 %") +
                " of the time, tried on the rest");
  const auto& baseline = channel.baseline;
  AddFigure(errors, "angle error, all data",
            added ? channel.fitted_angle_rms_deg : HeldOut{baseline.angle_rms_deg}, "deg",
            "of the data that all was chosen by and fitted to");
  AddFigure(errors, "whitened rms, all data",
            added ? channel.fitted_whitened_rms : HeldOut{baseline.whitened_rms}, "", kWhite);
  return errors;
}

// Which effects the error held out is of, where they are not those that were named.
std::string TrainingNote(const ChannelTrace& channel) {
  if (channel.effects.empty() || !std::isfinite(channel.heldout_whitened_rms.after)) return "";
  std::vector<std::string> found = channel.training_effects, named;
  for (const auto& effect : channel.effects) named.push_back(effect.id);
  std::ranges::sort(found);
  std::ranges::sort(named);
  if (found == named) return "";
  return "Held out is the error of " +
         (found.empty()
              ? "the baseline alone, as two thirds of the data ask for no effect"
              : fmt::format("{}, as two thirds of the data ask for", fmt::join(found, ", ")));
}

// Not where what these data cannot tell from it is another's.
bool IsOwnerCertain(const calibration::TracedEffect& effect) {
  return std::ranges::all_of(effect.rivals, [&effect](const std::string& rival) {
    const calibration::Effect* other = calibration::FindEffect(rival);
    return other != nullptr && other->owner == effect.owner;
  });
}

}  // namespace

std::string AxisName(SensorAxis axis) { return {"xyz"[static_cast<std::size_t>(axis)]}; }
std::string GyroName(SensorAxis axis) { return "gyro " + AxisName(axis); }

std::string Capitalized(std::string text) {
  if (!text.empty())
    text.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(text.front())));
  return text;
}

std::string BeforeAfter(const HeldOut& figure, std::string (*format)(double)) {
  if (!std::isfinite(figure.after))
    return std::isfinite(figure.before) ? format(figure.before) : "-";
  return format(figure.before) + " → " + format(figure.after);
}

Text Reduction(const HeldOut& figure) {
  if (!std::isfinite(figure.before) || !std::isfinite(figure.after) || figure.before <= 0.0)
    return {};
  const double share = 1.0 - figure.after / figure.before;
  Text point = std::fabs(share) < 5e-4 ? Text("unchanged") : Change(share);
  const auto [low, high] = figure.reduction_ci95;
  if (!std::isfinite(low) || !std::isfinite(high)) return point;
  const Text begin = point + " (" + Number("95 %") + ": ";
  if (low < 0.0 && high > 0.0) return begin + Change(low) + " to " + Change(high) + ")";
  const bool more = low < 0.0;
  return begin + Number(fmt::format("{:.1f}", 100.0 * (more ? -high : low))) + " to " +
         Change(more ? low : high) + ")";
}

std::string VerdictWords(const std::string& verdict) {
  if (verdict == "none") return "nothing beyond the baseline";
  std::string words = verdict;
  std::ranges::replace(words, '_', ' ');
  return words;
}

Text NamesOfEffects(const ChannelTrace& channel, bool owners) {
  struct Named {
    Text name;
    int times;
    std::string owner;
  };
  std::vector<Named> all;
  bool rivals = false;
  for (const calibration::TracedEffect& effect : channel.effects) {
    std::vector<Text> one = {Code(effect.id)};
    for (const std::string& rival : effect.rivals) one.push_back(Code(rival));
    rivals = rivals || one.size() > 1;
    const Text name = Join(one, " or ");
    const auto same = std::ranges::find_if(all, [&](const Named& n) { return n.name == name; });
    if (same != all.end()) {
      ++same->times;
    } else {
      const bool own = effect.owner == calibration::EffectOwner::kGyro || !IsOwnerCertain(effect);
      all.push_back({name, 1, own ? "" : fmt::format("the {}'s", Name(effect.owner))});
    }
  }
  std::vector<Text> names;
  for (const Named& one : all) {
    const Text note = Join(
        {one.times > 1 ? fmt::format("{} times", one.times) : "", owners ? one.owner : ""}, ", ");
    names.push_back(note.empty() ? one.name : one.name + " (" + note + ")");
  }
  // "a, b or c" would leave open what belongs together.
  return Join(names, rivals ? "; " : ", ");
}

Text VerdictSentence(const ChannelTrace& channel) {
  if (channel.verdict == Verdict::kCannotBe) return Clause(channel.summary);
  const std::string words = VerdictWords(Name(channel.verdict));
  if (!channel.effects.empty()) return words + " by " + NamesOfEffects(channel, false);
  if (!IsTraced(channel)) return "not traced; the remarks say why";
  if (channel.verdict == Verdict::kNone) return words;
  return Join({words, Clause(channel.summary)}, "; ");
}

Document ErrorBlocks(const ChannelTrace& channel) {
  Document blocks;
  Add(blocks, ErrorsOf(channel));
  if (blocks.empty()) return blocks;
  if (channel.effects.empty())
    Add(blocks,
        Paragraph{"Nothing was added: these are the figures of the baseline alone.", "note"});
  Add(blocks, Paragraph{TrainingNote(channel), "note"});
  return blocks;
}

Paragraph OffsetNote(const ChannelTrace& channel) {
  const double reference_degC = channel.baseline.reference_degC;
  if (!std::isfinite(reference_degC)) return {};
  return {"zero_rate_offset is that at " + Number(fmt::format("{:.2f}", reference_degC)) +
              " degC, from which the powers of the temperature are counted",
          "note"};
}

Document RemainingBlocks(const ChannelTrace& channel) {
  if (!std::isfinite(channel.baseline.whitened_rms)) return {};
  const auto& remaining = channel.remaining;
  Document blocks;
  if (remaining.findings.empty()) {
    Add(blocks,
        Paragraph{remaining.white ? "white noise" : "the rounding of the encoder, and noise"});
    return blocks;
  }
  Add(blocks, Paragraph{remaining.white ? "the rest is white, but:" : "the rest is not white:"});
  List findings;
  for (const calibration::Finding& finding : remaining.findings)
    findings.items.push_back(FindingText(finding) + " (" + Number(FormatPValue(finding.p_value)) +
                             ")");
  Add(blocks, std::move(findings));
  return blocks;
}

}  // namespace gyrobench::presentation
