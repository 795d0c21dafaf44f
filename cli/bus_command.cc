// How the stand's lines do, as the daemon counts it.
#include <fmt/format.h>
#include <poll.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/json_text.h"
#include "cli/commands.h"
#include "cli/control_client.h"
#include "cli/exit_status.h"
#include "cli/interrupt_watch.h"
#include "cli/json_field.h"
#include "presentation/document.h"
#include "presentation/number.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

using Json = nlohmann::json;

// What was counted is at hand: a daemon that takes longer hangs.
constexpr double kPatience_s = 5.0;

std::string Percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.1f} %", 100.0 * share) : "-";
}

std::string Milliseconds(double seconds) {
  return std::isfinite(seconds) ? presentation::FormatNumber(1e3 * seconds, 2) : "-";
}

// "2 without a reply, 1 refused, 1 given up, silent now"; nothing where no try failed.
std::string FailedText(const Json& unit, const Json& recent) {
  std::string text;
  for (const auto& [key, words] : {std::pair{"silent", "without a reply"},
                                   {"unreadable", "with a bad reply"},
                                   {"refused", "refused"},
                                   {"line_lost", "on a lost line"},
                                   {"given_up", "given up"}}) {
    const std::int64_t count = Integer(unit, key);
    if (count == 0) continue;
    text +=
        fmt::format("{}{} {}", text.empty() ? "" : ", ", presentation::FormatCount(count), words);
  }
  if (Integer(recent, "given_up") > 0 && std::isnan(Number(recent, "latency_median_s")))
    text += ", silent now";
  return text;
}

std::string TitleOf(const Json& bus) {
  const Json& recent = Field(bus, "recent");
  std::string title = fmt::format("{}: {} busy in the last {:.0f} s", Text(bus, "line"),
                                  Percent(Number(recent, "load")), Number(recent, "seconds"));
  const double expected = Number(bus, "expected_load");
  if (std::isfinite(expected)) title += fmt::format(", {} expected in a run", Percent(expected));
  return title;
}

// Load and times are those of the last seconds, counts those since the daemon started.
presentation::Table TableOf(const Json& bus) {
  using Kind = presentation::Column::Kind;
  presentation::Table table{{{"device"},
                             {"unit", Kind::kCount},
                             {"busy", Kind::kCount},
                             {"ms", Kind::kCount},
                             {"99 %", Kind::kCount},
                             {"asked", Kind::kCount},
                             {"retries", Kind::kCount},
                             {"failures", Kind::kNote}},
                            {}};
  const Json& all = Field(Field(bus, "all"), "units");
  const Json& recent = Field(Field(bus, "recent"), "units");
  for (std::size_t i = 0; i < all.size() && i < recent.size(); ++i) {
    std::vector<presentation::Text> row = {Text(all[i], "device"), Plain(Field(all[i], "unit")),
                                           Percent(Number(recent[i], "load")),
                                           Milliseconds(Number(recent[i], "latency_median_s")),
                                           Milliseconds(Number(recent[i], "latency_99_s"))};
    for (const char* count : {"transactions", "retries"})
      row.emplace_back(presentation::FormatCount(Integer(all[i], count)));
    row.emplace_back(FailedText(all[i], recent[i]));
    table.Add(std::move(row));
  }
  return table;
}

std::string TextOf(const Json& status, const presentation::Terminal& terminal) {
  presentation::Document document;
  for (const Json& bus : Field(status, "buses")) {
    presentation::Section section;
    section.title = presentation::Strong(TitleOf(bus));
    Add(section.blocks, TableOf(bus));
    if (section.blocks.empty())
      Add(section.blocks, presentation::Paragraph{"Nobody was asked yet."});
    Add(document, std::move(section));
  }
  Add(document,
      presentation::Paragraph{
          "busy, ms (median from request to reply) and 99 % are of the last seconds; counts are "
          "since the daemon started. A line is busy as well while it waits for a device that does "
          "not answer."});
  return RenderText(document, terminal);
}

}  // namespace

int Bus(const Options& options) {
  const BenchPlace place(options.bench);
  const ControlClient client(place.Socket(), place.DaemonCommand(), kPatience_s);
  // Once, Ctrl-C ends the program as ever.
  std::optional<InterruptWatch> interrupt;
  if (options.every_s > 0.0) interrupt.emplace();
  const presentation::Terminal terminal = presentation::DescribeTerminal(fileno(stdout));
  while (true) {
    const Json status = client.Get("/v1/bus");
    if (options.json) {
      fmt::print("{}\n", JsonText(status, options.every_s > 0.0 ? -1 : 2));
    } else {
      const bool redraws = options.every_s > 0.0 && terminal.redraws;
      fmt::print("{}{}", redraws ? "\x1b[H\x1b[J" : "", TextOf(status, terminal));
    }
    std::fflush(stdout);
    if (!interrupt) return kDone;
    pollfd wait = {interrupt->descriptor(), POLLIN, 0};
    poll(&wait, 1, static_cast<int>(1e3 * options.every_s));
    if (interrupt->Take()) return kDone;
  }
}

}  // namespace gyrobench::cli
