#include "cli/drive_settings.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cctype>
#include <cstdio>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <variant>

#include "base/error.h"
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

// Two drives that hold each other's value are more likely the one for the other. Empty where there
// are none.
std::string Exchanged(const std::vector<Planned>& planned) {
  for (const Planned& one : planned) {
    for (const Planned& other : planned) {
      if (one.setting.found == other.setting.expected && one.setting.name == other.setting.name &&
          other.setting.found == one.setting.expected && one.drive->unit < other.drive->unit)
        return fmt::format(
            "units {} and {} hold each other's {}: are their unit numbers or their lines "
            "exchanged? gyrobench run commission finds out which table each turns",
            one.drive->unit, other.drive->unit, one.setting.name);
    }
  }
  return "";
}

// Why nothing is to be written, in a sentence; empty where the reports say it.
std::string WhyNothing(const std::vector<LineReport>& reports) {
  for (const LineReport& report : reports) {
    if (!report.error.empty()) return "";
    for (const FoundUnit& found : report.found) {
      if (found.identity.settings.empty() || found.expected.empty()) continue;
      return fmt::format(
          "{} is not written to, as it answers at {}: set it to its line's {} first.",
          found.expected, Describe(found.setting), Describe(drivers::SettingOf(report.bus)));
    }
  }
  return "Nothing to write: the drives that answered are set as the stand file says.";
}

// Throws UsageError where nobody can answer.
bool MayWrite(std::size_t count) {
  if (isatty(STDIN_FILENO) == 0)
    throw UsageError("--write asks before it writes: start it in a terminal, or give --yes");
  fmt::print("\nWrite {} into the drive{}? Nothing moves. [y/N] ",
             count == 1 ? "this value" : fmt::format("these {} values", count),
             count == 1 ? "" : "s");
  std::fflush(stdout);
  std::string line, answer;
  if (!std::getline(std::cin, line)) fmt::print("\n");
  for (const char c : line)
    if (c != ' ') answer += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return answer == "y" || answer == "yes";
}

// What was written, or why not, as of --json.
nlohmann::ordered_json Write(const Planned& one, Clock& clock, Clock::Participant& participant) {
  nlohmann::ordered_json out = {{"bus", one.report->bus.name},
                                {"unit", one.drive->unit},
                                {"device", one.drive->expected},
                                {"parameter", one.setting.name},
                                {"from", one.setting.found},
                                {"to", one.setting.expected},
                                {"saved", false},
                                {"error", ""}};
  try {
    drivers::ModbusBus bus(one.report->bus, clock, participant);
    out["saved"] = Set(bus, {one.drive->expected, one.drive->unit}, one.map, one.setting) ==
                   drivers::Kept::kAlways;
  } catch (const DeviceError& error) {
    out["error"] = error.what();
  }
  return out;
}

// As they are now, of the drives that were not as they were to be.
void AskAgain(const config::StandConfig& stand, Clock& clock, Clock::Participant& participant,
              std::vector<LineReport>* reports) {
  for (LineReport& report : *reports) {
    for (FoundUnit& found : report.found) {
      if (found.identity.settings.empty() || !report.IsOwn(found.setting)) continue;
      const LineReport now =
          drivers::ScanLine(stand, report.bus, {{found.unit}, {drivers::SettingOf(report.bus)}},
                            clock, participant, [](double, const std::string&) { return true; });
      if (now.found.size() == 1) found = now.found.front();
    }
  }
}

}  // namespace

nlohmann::ordered_json WriteDriveSettings(const config::StandConfig& stand, const Options& options,
                                          Clock& clock, Clock::Participant& participant,
                                          std::vector<LineReport>* reports) {
  nlohmann::ordered_json written = nlohmann::ordered_json::array();
  const std::vector<Planned> planned = PlanOf(stand, *reports);
  if (planned.empty()) {
    const std::string why = WhyNothing(*reports);
    if (!options.json && !why.empty()) fmt::print("\n{}\n", why);
    return written;
  }
  if (!options.json) Show(planned);
  const std::string exchanged = Exchanged(planned);
  if (!exchanged.empty() && options.yes)
    throw UsageError(exchanged + ". Nothing was written; without --yes it is asked");
  if (!exchanged.empty()) fmt::print("\nMind: {}.\n", exchanged);
  if (!options.yes && !MayWrite(planned.size())) {
    fmt::print("Nothing was written.\n");
    return written;
  }
  if (!options.json) fmt::print("\n");
  for (const Planned& one : planned) {
    written.push_back(Write(one, clock, participant));
    if (options.json) continue;
    const std::string error = written.back()["error"];
    fmt::print("{}: {}\n", one.drive->expected,
               !error.empty()
                   ? error
                   : fmt::format("{} {}, {}.", one.setting.expected, one.setting.name,
                                 written.back()["saved"].get<bool>() ? "saved"
                                                                     : "until it is switched off"));
  }
  AskAgain(stand, clock, participant, reports);
  return written;
}

}  // namespace gyrobench::cli
