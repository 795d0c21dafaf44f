#include "cli/drive_settings.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "cli/exit_status.h"
#include "drivers/drive_setting.h"
#include "presentation/document.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

using drivers::FoundUnit;
using drivers::LineReport;

struct Planned {
  const LineReport* report;
  const FoundUnit* drive;
  config::DriveMap map;
  drivers::WrongSetting setting;
};

std::vector<Planned> PlanOf(const config::StandConfig& stand,
                            const std::vector<LineReport>& reports) {
  std::vector<Planned> planned;
  for (const LineReport& report : reports) {
    // Whoever answers to every number is not the drive that is meant.
    if (report.all_answer || report.all_unreadable) continue;
    for (const drivers::ExpectedUnit& expected : drivers::ExpectedOn(stand, report.bus.name)) {
      const auto* map = std::get_if<config::DriveMap>(&expected.map);
      for (const FoundUnit& found : report.found) {
        if (map == nullptr || found.expected != expected.device || !report.IsOwn(found.setting))
          continue;
        for (const drivers::WrongSetting& setting : found.identity.settings)
          planned.push_back({&report, &found, *map, setting});
      }
    }
  }
  return planned;
}

void Show(const std::vector<Planned>& planned) {
  using Kind = presentation::Column::Kind;
  presentation::Table table{{{"drive"},
                             {"unit", Kind::kCount},
                             {"parameter"},
                             {"register"},
                             {"holds", Kind::kCount},
                             {"stand file", Kind::kCount},
                             {"kept beyond a power-off", Kind::kNote}},
                            {}};
  for (const Planned& one : planned) {
    table.Add({one.drive->expected, std::to_string(one.drive->unit), one.setting.name,
               fmt::format("0x{:04X}", one.setting.address), std::to_string(one.setting.found),
               std::to_string(one.setting.expected),
               one.map.save_value ? "yes" : "no: its map has no save_value"});
  }
  presentation::Document document;
  presentation::Section section;
  section.title = presentation::Strong("To be written");
  Add(section.blocks, std::move(table));
  Add(document, std::move(section));
  fmt::print("\n{}", RenderText(document, presentation::DescribeTerminal(fileno(stdout))));
}

// Throws UsageError where nobody can answer.
bool MayWrite(std::size_t count, bool json) {
  if (json || isatty(STDIN_FILENO) == 0)
    throw UsageError("--write asks before it writes: start it in a terminal, or give --yes");
  fmt::print("\nWrite {} into the drive{}? Nothing moves. [y/N] ",
             count == 1 ? "this value" : fmt::format("these {} values", count),
             count == 1 ? "" : "s");
  std::fflush(stdout);
  std::string answer;
  std::getline(std::cin, answer);
  return answer == "y" || answer == "Y" || answer == "yes";
}

}  // namespace

nlohmann::ordered_json WriteDriveSettings(const config::StandConfig& stand, const Options& options,
                                          Clock& clock, Clock::Participant& participant,
                                          std::vector<LineReport>* reports) {
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  const std::vector<Planned> planned = PlanOf(stand, *reports);
  if (planned.empty()) {
    if (!options.json) fmt::print("\nNo drive that answers holds a parameter to be written.\n");
    return written;
  }
  if (!options.json) Show(planned);
  if (!options.yes && !MayWrite(planned.size(), options.json)) {
    fmt::print("Nothing was written.\n");
    return written;
  }
  for (const Planned& one : planned) {
    drivers::ModbusBus bus(one.report->bus, clock, participant);
    const drivers::Kept kept =
        Set(bus, {one.drive->expected, one.drive->unit}, one.map, one.setting);
    const bool saved = kept == drivers::Kept::kAlways;
    written.push_back({{"bus", one.report->bus.name},
                       {"unit", one.drive->unit},
                       {"device", one.drive->expected},
                       {"parameter", one.setting.name},
                       {"from", one.setting.found},
                       {"to", one.setting.expected},
                       {"saved", saved}});
    if (!options.json)
      fmt::print("{}: {} {}, {}.\n", one.drive->expected, one.setting.expected, one.setting.name,
                 saved ? "saved" : "until it is switched off");
  }
  for (LineReport& report : *reports) {
    for (FoundUnit& found : report.found) {
      if (found.identity.settings.empty() || !report.IsOwn(found.setting)) continue;
      const LineReport now =
          drivers::ScanLine(stand, report.bus, {{found.unit}, {drivers::SettingOf(report.bus)}},
                            clock, participant, [](double, const std::string&) {});
      if (now.found.size() == 1) found = now.found.front();
    }
  }
  return written;
}

}  // namespace gyrobench::cli
