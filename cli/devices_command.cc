// What answers on the stand's Modbus lines; the one command that opens them itself.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.h"
#include "base/error.h"
#include "base/json_text.h"
#include "base/nearest_word.h"
#include "cli/commands.h"
#include "cli/drive_settings.h"
#include "cli/exit_status.h"
#include "cli/inputs.h"
#include "cli/interrupt_watch.h"
#include "config/stand_config.h"
#include "drivers/line_scan.h"
#include "drivers/modbus_line.h"
#include "drivers/stand_lock.h"
#include "presentation/document.h"
#include "presentation/text_layout.h"

namespace gyrobench::cli {
namespace {

using OrderedJson = nlohmann::ordered_json;
using drivers::FoundUnit;
using drivers::LineReport;
using drivers::UnitKind;

bool IsSerial(const config::BusConfig& bus) {
  return bus.transport == config::BusConfig::Transport::kRtu;
}

// Each once, in the order of the stand file.
std::vector<config::BusConfig> ChosenBuses(const config::StandConfig& stand,
                                           const std::vector<std::string>& names) {
  if (names.empty()) return stand.buses;
  std::vector<std::string> known;
  for (const config::BusConfig& bus : stand.buses) known.push_back(bus.name);
  for (const std::string& name : names) {
    if (std::ranges::find(known, name) != known.end()) continue;
    throw UsageError(
        fmt::format("no bus '{}' in {}: {}", name, stand.file.string(), Suggestion(name, known)));
  }
  std::vector<config::BusConfig> chosen;
  for (const config::BusConfig& bus : stand.buses) {
    if (std::ranges::find(names, bus.name) != names.end()) chosen.push_back(bus);
  }
  return chosen;
}

drivers::ScanOptions ScanOf(const Options& options, const config::BusConfig& bus) {
  drivers::ScanOptions scan{options.units, {}};
  for (const int baud : options.baud_rates) {
    const drivers::LineSetting setting{baud, bus.parity, bus.stop_bits};
    const bool known = std::ranges::find(scan.settings, setting) != scan.settings.end();
    if (IsSerial(bus) && !known) scan.settings.push_back(setting);
  }
  return scan;
}

std::string StandFileText(const FoundUnit& found) {
  if (found.expected.empty()) return "not in the stand file";
  if (found.as_expected) return found.expected;
  return "expected " + found.expected;
}

std::string NameText(const FoundUnit& found) {
  const std::string name = NameOf(found.identity.kind);
  return found.identity.model.empty() ? name : fmt::format("{} ({})", name, found.identity.model);
}

// What is to be done about one that answers; empty where nothing is.
std::vector<std::string> AdviceOn(const LineReport& report, const FoundUnit& found) {
  std::vector<std::string> advice;
  if (found.identity.kind == UnitKind::kUnreadable) {
    return {
        fmt::format("Unit {}: {}, each time. Do two devices have this number, or is it set to "
                    "another parity? Disconnect all but one, and ask again.",
                    found.unit, found.identity.says)};
  }
  if (found.expected.empty()) return {};
  if (!report.IsOwn(found.setting)) {
    advice.push_back(
        fmt::format("{} (unit {}) answers at {}, and the line is set to {}: change "
                    "one of them.",
                    found.expected, found.unit, Describe(found.setting),
                    Describe(drivers::SettingOf(report.bus))));
  }
  for (const std::string& wrong : found.identity.wrong)
    advice.push_back(fmt::format("{} (unit {}): {}", found.expected, found.unit, wrong));
  if (found.as_expected || !advice.empty()) return advice;
  if (found.identity.kind == UnitKind::kUnknown) {
    return {
        fmt::format("Unit {} is to be {}, and does not answer as its register map says: check "
                    "the model, and the map against the device's manual.",
                    found.unit, found.expected)};
  }
  return {fmt::format("Unit {} is to be {}, and answers as {}: correct the unit numbers.",
                      found.unit, found.expected, NameOf(found.identity.kind))};
}

// Whether one that answers, and that no number of the stand file speaks of, may be of this kind.
bool MayBe(const FoundUnit& found, UnitKind kind) {
  const std::vector<UnitKind>& may_be = found.identity.may_be;
  return found.expected.empty() &&
         (found.identity.kind == kind || std::ranges::find(may_be, kind) != may_be.end());
}

// "unit 21 of bus b"; that of another line with the same number where there is one: the lines may
// have been exchanged. Empty where none may be it.
std::string StandInFor(const drivers::MissingUnit& missing, const LineReport& own,
                       const std::vector<LineReport>& all) {
  std::string text, same_number;
  for (const LineReport& report : all) {
    for (const FoundUnit& found : report.found) {
      if (report.all_answer || !MayBe(found, missing.kind)) continue;
      const std::string name = fmt::format("unit {} of bus {}", found.unit, report.bus.name);
      if (text.empty()) text = name;
      if (found.unit == missing.unit && report.bus.name != own.bus.name) same_number = name;
    }
  }
  return same_number.empty() ? text : same_number;
}

std::string AdviceOn(const drivers::MissingUnit& missing, const LineReport& report,
                     const std::vector<LineReport>& all) {
  const std::string stand_in = StandInFor(missing, report, all);
  const std::string silent =
      fmt::format("{} (unit {}) does not answer", missing.device, missing.unit);
  if (stand_in.empty())
    return silent + ": check its power, the cable, its unit number and its baud rate.";
  return fmt::format(
      "{}, and {}, which is not in the stand file, may be it: correct its number or "
      "its bus, or exchange the lines.",
      silent, stand_in);
}

// What is to be done about a line.
std::vector<std::string> AdviceOn(const LineReport& report, const std::vector<LineReport>& all) {
  if (report.all_unreadable) {
    return {
        "Every unit number that was asked gives replies that cannot be read: the adapter hears "
        "what it sends itself (switch off its echo), or the line is disturbed."};
  }
  std::vector<std::string> advice;
  if (report.all_answer) {
    advice.push_back(
        "Every unit number that was asked gives an answer: the device at the other end "
        "does not look at the number. Only what the stand file has is shown.");
  }
  for (const FoundUnit& found : report.found) {
    for (std::string& one : AdviceOn(report, found)) advice.push_back(std::move(one));
  }
  if (report.found.empty() && report.missing.size() > 1) {
    const bool elsewhere = std::ranges::any_of(report.missing, [&](const auto& missing) {
      return !StandInFor(missing, report, all).empty();
    });
    if (!elsewhere) {
      return {
          fmt::format("None of the {} devices that the stand file has on this line answers at "
                      "any setting that was tried: is it the right adapter, are its wires A "
                      "and B exchanged, have the devices power?",
                      report.missing.size())};
    }
  }
  for (const drivers::MissingUnit& missing : report.missing)
    advice.push_back(AdviceOn(missing, report, all));
  return advice;
}

std::string RegistersText(const LineReport& report, const FoundUnit& found) {
  if (report.IsOwn(found.setting)) return found.identity.says;
  return fmt::format("at {}: {}", Describe(found.setting), found.identity.says);
}

presentation::Section SectionOf(const LineReport& report, const std::vector<LineReport>& all) {
  presentation::Section section;
  const std::string line = drivers::DescribeBus(report.bus);
  std::string title =
      fmt::format("{}: {} unit number{} asked", line, report.asked, report.asked == 1 ? "" : "s");
  if (report.stopped) title += ", then stopped by Ctrl-C";
  if (!report.error.empty()) title = line + ": not asked to the end";
  section.title = presentation::Strong(title);
  using Kind = presentation::Column::Kind;
  presentation::Table table{
      {{"unit", Kind::kCount}, {"answers as"}, {"stand file"}, {"its registers", Kind::kNote}}, {}};
  for (const FoundUnit& found : report.found) {
    if (report.all_unreadable || (report.all_answer && found.expected.empty())) continue;
    table.Add({std::to_string(found.unit), NameText(found), StandFileText(found),
               RegistersText(report, found)});
  }
  Add(section.blocks, std::move(table));
  if (!report.error.empty()) {
    Add(section.blocks, presentation::Paragraph{report.error});
  } else if (report.found.empty() && report.asked > 0) {
    Add(section.blocks, presentation::Paragraph{"Nothing answers."});
  }
  Add(section.blocks, presentation::ListOf(AdviceOn(report, all)));
  return section;
}

struct NotAsked {
  std::string bus;
  drivers::MissingUnit device;
};

// Devices of the stand file, of the lines that were asked and of the others.
std::vector<NotAsked> NotAskedOf(const config::StandConfig& stand,
                                 const std::vector<LineReport>& reports) {
  std::vector<NotAsked> out;
  for (const config::BusConfig& bus : stand.buses) {
    const auto report = std::ranges::find_if(
        reports, [&](const LineReport& one) { return one.bus.name == bus.name; });
    if (report != reports.end()) {
      for (const drivers::MissingUnit& device : report->not_asked)
        out.push_back({bus.name, device});
      continue;
    }
    for (const drivers::ExpectedUnit& unit : drivers::ExpectedOn(stand, bus.name))
      out.push_back({bus.name, {unit.unit, unit.device, unit.kind}});
  }
  return out;
}

// What was asked of the stand file, in a sentence or two at the end.
std::string ClosingText(const config::StandConfig& stand, const std::vector<LineReport>& reports,
                        bool as_expected) {
  std::size_t devices = 0, answer = 0;
  for (const config::BusConfig& bus : stand.buses)
    devices += drivers::ExpectedOn(stand, bus.name).size();
  for (const LineReport& report : reports)
    answer +=
        static_cast<std::size_t>(std::ranges::count_if(report.found, &FoundUnit::as_expected));
  std::vector<std::string> names;
  for (const NotAsked& one : NotAskedOf(stand, reports)) names.push_back(one.device.device);
  const std::string others =
      names.empty() ? "" : fmt::format(" Nothing is known of {}.", fmt::join(names, ", "));
  if (!as_expected)
    return fmt::format("{} of the {} devices of the stand file answer as expected.{}", answer,
                       devices, others);
  if (answer < devices)
    return fmt::format("The {} devices of the stand file that were asked answer as expected.{}",
                       answer, others);
  return fmt::format(
      "All {} devices of the stand file answer as expected. Devices of one model "
      "are alike here: which axis is which, gyrobench run commission finds out by small moves.",
      devices);
}

OrderedJson ToJson(const LineReport& report, const std::vector<LineReport>& all) {
  OrderedJson found = OrderedJson::array();
  for (const FoundUnit& one : report.found) {
    OrderedJson unit = {{"unit", one.unit},
                        {"kind", NameOf(one.identity.kind)},
                        {"model", one.identity.model},
                        {"registers", one.identity.says},
                        {"wrong", one.identity.wrong},
                        {"expected", one.expected},
                        {"as_expected", one.as_expected}};
    if (IsSerial(report.bus)) unit["setting"] = Describe(one.setting);
    found.push_back(std::move(unit));
  }
  OrderedJson missing = OrderedJson::array();
  for (const drivers::MissingUnit& one : report.missing)
    missing.push_back({{"unit", one.unit}, {"device", one.device}});
  return {{"bus", report.bus.name},
          {"line", drivers::DescribeBus(report.bus)},
          {"units_asked", report.asked},
          {"found", found},
          {"missing", missing},
          {"all_unreadable", report.all_unreadable},
          {"all_answer", report.all_answer},
          {"error", report.error},
          {"stopped", report.stopped},
          {"as_expected", report.IsAsExpected()},
          {"advice", AdviceOn(report, all)}};
}

// Until Ctrl-C.
std::vector<LineReport> ScanAll(const config::StandConfig& stand, const Options& options,
                                InterruptWatch& interrupts, Clock& clock,
                                Clock::Participant& participant) {
  const std::vector<config::BusConfig> buses = ChosenBuses(stand, options.buses);
  WorkBar bar(options.quiet);
  std::vector<LineReport> reports;
  for (const config::BusConfig& bus : buses) {
    reports.push_back(drivers::ScanLine(stand, bus, ScanOf(options, bus), clock, participant,
                                        [&](double fraction, const std::string& doing) {
                                          bar.Show(fraction, doing);
                                          return !interrupts.Take();
                                        }));
    if (reports.back().stopped) break;
  }
  return reports;
}

void Print(const config::StandConfig& stand, const std::vector<LineReport>& reports) {
  presentation::Document document;
  for (const LineReport& report : reports) Add(document, SectionOf(report, reports));
  const bool as_expected = std::ranges::all_of(reports, &LineReport::IsAsExpected);
  Add(document, presentation::Paragraph{ClosingText(stand, reports, as_expected)});
  fmt::print("{}", RenderText(document, presentation::DescribeTerminal(fileno(stdout))));
}

}  // namespace

int Devices(const Options& options) {
  if (options.write && options.json && !options.yes)
    throw UsageError("--write with --json takes --yes: nobody is asked");
  const BenchPlace bench(options.bench);
  const config::StandConfig stand = bench.Stand();
  if (stand.virtual_stand) {
    throw UsageError(fmt::format(
        "{} is a virtual stand, whose lines are the daemon's own. A virtual stand on lines of this "
        "machine is served by: gyrobench-stand --config {}",
        stand.file.string(), stand.file.string()));
  }
  // A line has one master: no daemon starts meanwhile.
  const drivers::StandLock lock(stand, "gyrobench devices");
  const std::unique_ptr<Clock> clock = MakeSystemClock();
  const auto participant = clock->Join("devices");
  std::vector<LineReport> reports;
  bool stopped = false;
  {
    // What is asked before a write can be left by Ctrl-C as ever.
    InterruptWatch interrupts;
    reports = ScanAll(stand, options, interrupts, *clock, *participant);
    if (!options.json) Print(stand, reports);
    stopped = std::ranges::any_of(reports, &LineReport::stopped) || interrupts.Take();
  }
  OrderedJson written = OrderedJson::array();
  if (options.write && !stopped)
    written = WriteDriveSettings(stand, options, *clock, *participant, &reports);
  if (options.write && stopped && !options.json)
    fmt::print("\nNothing was written, because of Ctrl-C.\n");
  const bool as_expected = std::ranges::all_of(reports, &LineReport::IsAsExpected);
  if (options.json) {
    OrderedJson lines = OrderedJson::array();
    for (const LineReport& report : reports) lines.push_back(ToJson(report, reports));
    OrderedJson not_asked = OrderedJson::array();
    for (const NotAsked& one : NotAskedOf(stand, reports))
      not_asked.push_back(
          {{"bus", one.bus}, {"unit", one.device.unit}, {"device", one.device.device}});
    OrderedJson out = {{"format", "gyrobench.devices/1"},
                       {"as_expected", as_expected},
                       {"lines", lines},
                       {"not_asked", not_asked}};
    if (options.write) out["written"] = written;
    fmt::print("{}\n", JsonText(out, 2));
  } else if (!written.empty() && !as_expected) {
    fmt::print("\n");
    Print(stand, reports);
  } else if (!written.empty()) {
    fmt::print("\n{}\n", ClosingText(stand, reports, as_expected));
  }
  const bool failed = std::ranges::any_of(
      written, [](const OrderedJson& one) { return !one["error"].get<std::string>().empty(); });
  return as_expected && !failed ? kDone : kFailed;
}

}  // namespace gyrobench::cli
