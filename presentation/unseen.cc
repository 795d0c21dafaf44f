// What the data could not show, and what several axes say alike.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "presentation/number.h"
#include "presentation/sections.h"

namespace gyrobench::presentation {
namespace {

using calibration::ChannelTrace;
using calibration::TraceResult;
using calibration::Unidentifiable;

// Without the figures, which differ from effect to effect.
std::string ReasonOf(const Unidentifiable& one) {
  return one.limit ? "its bound here is beyond the largest size of such parts" : one.because;
}

// Effects that one reason hides, each with the manoeuvre that would show it.
struct Unseen {
  std::string reason;
  std::vector<std::pair<std::string, std::string>> effects;
  std::vector<SensorAxis> axes;
};

std::vector<Unseen> UnseenOf(const ChannelTrace& channel) {
  std::vector<Unseen> groups;
  for (const Unidentifiable& one : channel.unidentifiable) {
    const std::string reason = ReasonOf(one);
    auto same = std::ranges::find(groups, reason, &Unseen::reason);
    if (same == groups.end())
      same = groups.insert(groups.end(), Unseen{reason, {}, {channel.axis}});
    const std::pair effect(one.id, one.settled_by);
    if (std::ranges::find(same->effects, effect) == same->effects.end())
      same->effects.push_back(effect);
  }
  return groups;
}

// Axes of which the same holds share a group.
std::vector<Unseen> Joined(const TraceResult& trace) {
  std::vector<Unseen> all;
  for (const ChannelTrace& channel : trace.channels) {
    for (const Unseen& group : UnseenOf(channel)) {
      const auto same = std::ranges::find_if(all, [&](const Unseen& other) {
        return group.reason == other.reason && group.effects == other.effects;
      });
      if (same == all.end()) {
        all.push_back(group);
      } else {
        same->axes.push_back(channel.axis);
      }
    }
  }
  return all;
}

// "scale.g, gyro x: 0.03 1/g, of parts 0.001": how far the bound is beyond what parts show.
void AddFigures(const TraceResult& trace, const Unseen& group, const std::string& id,
                std::vector<Text>& figures) {
  for (const ChannelTrace& channel : trace.channels) {
    if (std::ranges::find(group.axes, channel.axis) == group.axes.end()) continue;
    for (const Unidentifiable& one : channel.unidentifiable) {
      if (one.id != id || !one.limit || ReasonOf(one) != group.reason) continue;
      figures.push_back(Code(id) + ", " + GyroName(channel.axis) + ": " +
                        Quantity(FormatNumber(one.limit->bound, 2), one.limit->unit) +
                        ", of parts " + Number(FormatNumber(one.limit->largest, 2)));
    }
  }
}

// Effects that one manoeuvre shows stand together.
Facts ByManoeuvre(const TraceResult& trace, const Unseen& group) {
  struct Line {
    std::string manoeuvre;
    std::vector<Text> ids, figures;
  };
  std::vector<Line> lines;
  for (const auto& [id, manoeuvre] : group.effects) {
    auto same = std::ranges::find(lines, manoeuvre, &Line::manoeuvre);
    if (same == lines.end()) same = lines.insert(same, Line{manoeuvre, {}, {}});
    same->ids.push_back(Code(id));
    AddFigures(trace, group, id, same->figures);
  }
  Facts facts;
  for (const Line& line : lines)
    facts.facts.push_back({Join(line.ids, ", "), line.manoeuvre, Join(line.figures, "; ")});
  return facts;
}

// "gyro x, y: "; nothing where it holds for all.
std::string For(const std::vector<std::string>& axes, std::size_t all) {
  return axes.size() == all ? "" : fmt::format("gyro {}: ", fmt::join(axes, ", "));
}

}  // namespace

Section UnseenSection(const TraceResult& trace) {
  Section section{"Not to be seen in these data, and what would show it", {}};
  for (const Unseen& group : Joined(trace)) {
    std::vector<std::string> axes;
    for (const SensorAxis axis : group.axes) axes.push_back(AxisName(axis));
    Add(section.blocks,
        Section{
            For(axes, trace.channels.size()) + group.reason, {{ByManoeuvre(trace, group)}}, ""});
  }
  return section;
}

void SharedTexts::Add(SensorAxis axis, const std::string& text) {
  const std::string who = AxisName(axis);
  auto same = std::ranges::find_if(texts_, [&](const auto& seen) { return seen.first == text; });
  if (same == texts_.end()) same = texts_.insert(same, {text, {}});
  if (std::ranges::find(same->second, who) == same->second.end()) same->second.push_back(who);
}

std::vector<Text> SharedTexts::Texts(std::size_t all) const {
  std::vector<Text> texts;
  for (const auto& [text, axes] : texts_) texts.emplace_back(For(axes, all) + text);
  return texts;
}

List TraceRemarks(const TraceResult& trace) {
  SharedTexts own;
  for (const ChannelTrace& channel : trace.channels)
    for (const std::string& remark : channel.remarks) own.Add(channel.axis, remark);
  List list{own.Texts(trace.channels.size()), "! "};
  for (const std::string& remark : trace.remarks) {
    if (std::ranges::find(list.items, Text(remark)) == list.items.end())
      list.items.emplace_back(remark);
  }
  return list;
}

}  // namespace gyrobench::presentation
