#include "cli/unseen_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "cli/effect_text.h"
#include "cli/json_field.h"
#include "report/reason.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;
using Texts = std::vector<std::string>;

void AddOnce(Texts& list, const std::string& text) {
  if (!text.empty() && std::find(list.begin(), list.end(), text) == list.end())
    list.push_back(text);
}

// Effects that one reason hides, each with the manoeuvre that would show it.
struct Unseen {
  std::string reason;
  std::vector<std::pair<std::string, std::string>> effects;
  Texts axes;
  bool SameEffects(const Unseen& other) const {
    return reason == other.reason && effects == other.effects;
  }
};

std::vector<Unseen> UnseenOf(const Json& channel) {
  std::vector<Unseen> groups;
  for (const Json& one : Field(channel, "unidentifiable")) {
    const std::string reason = report::SplitReason(Text(one, "because")).kind;
    auto same = std::find_if(groups.begin(), groups.end(),
                             [&](const Unseen& group) { return group.reason == reason; });
    if (same == groups.end())
      same = groups.insert(groups.end(), Unseen{reason, {}, {Text(channel, "gyro")}});
    const std::pair effect(Text(one, "id"), Text(one, "settled_by"));
    if (std::find(same->effects.begin(), same->effects.end(), effect) == same->effects.end())
      same->effects.push_back(effect);
  }
  return groups;
}

std::vector<Unseen> Joined(const Json& channels) {
  std::vector<Unseen> all;
  for (const Json& channel : channels) {
    for (const Unseen& group : UnseenOf(channel)) {
      const auto same = std::find_if(all.begin(), all.end(),
                                     [&](const Unseen& other) { return group.SameEffects(other); });
      if (same == all.end()) {
        all.push_back(group);
      } else {
        same->axes.push_back(group.axes.front());
      }
    }
  }
  return all;
}

// Effects that one manoeuvre shows stand together.
std::vector<std::pair<std::string, std::string>> ByManoeuvre(const Unseen& group) {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const auto& [id, manoeuvre] : group.effects) {
    const auto same =
        std::find_if(lines.begin(), lines.end(),
                     [&, &by = manoeuvre](const auto& line) { return line.second == by; });
    if (same == lines.end()) {
      lines.emplace_back(id, manoeuvre);
    } else {
      same->first += ", " + id;
    }
  }
  return lines;
}

// "gyro x, y: "; nothing where it holds for all.
std::string For(const Texts& axes, const Json& channels) {
  return axes.size() == channels.size() ? "" : fmt::format("gyro {}: ", fmt::join(axes, ", "));
}

}  // namespace

std::string UnseenText(const Json& channels, const Terminal& terminal) {
  std::string text;
  for (const Unseen& group : Joined(channels)) {
    text += Paragraph(For(group.axes, channels) + group.reason, terminal, 2);
    for (const auto& [ids, manoeuvre] : ByManoeuvre(group)) {
      text += Paragraph(ids + (manoeuvre.empty() ? "" : ": " + manoeuvre), terminal, 4);
    }
  }
  return text.empty() ? "" : "Not to be seen in these data, and what would show it\n" + text;
}

std::string TraceRemarks(const Json& trace, const Terminal& terminal) {
  const Json& channels = Field(trace, "channels");
  Texts remarks;
  for (const Json& channel : channels)
    for (const Json& remark : Field(channel, "remarks")) AddOnce(remarks, Plain(remark));
  std::string text;
  for (const std::string& remark : remarks) {
    Texts axes;
    for (const Json& channel : channels) {
      const Json& own = Field(channel, "remarks");
      if (std::find(own.begin(), own.end(), Json(remark)) != own.end())
        axes.push_back(Text(channel, "gyro"));
    }
    text += Paragraph("! " + For(axes, channels) + remark, terminal, 0);
  }
  Texts of_all;
  for (const Json& remark : Field(trace, "remarks")) AddOnce(of_all, Plain(remark));
  for (const std::string& remark : of_all) text += Paragraph("! " + remark, terminal, 0);
  return text;
}

}  // namespace gyrobench::cli
