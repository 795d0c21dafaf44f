// What answers on the stand's Modbus lines; the one command that opens them itself.
#include <fmt/format.h>

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
#include "cli/control_client.h"
#include "cli/exit_status.h"
#include "cli/inputs.h"
#include "config/stand_config.h"
#include "drivers/line_scan.h"
#include "drivers/modbus_line.h"
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

// A line has one master. A serial one is locked by who opens it; of the others the daemon knows.
void RefuseBesideDaemon(const BenchPlace& bench) {
  try {
    ControlClient(bench.Socket(), bench.DaemonCommand(), 5.0).Get("/v1/status");
  } catch (const UnreachableError&) {
    return;
  }
  throw Error(
      fmt::format("gyrobenchd runs on this stand (control socket {}) and has its lines: end "
                  "it first; what it knows of its devices says: gyrobench status",
                  bench.Socket().string()));
}

std::vector<config::BusConfig> ChosenBuses(const config::StandConfig& stand,
                                           const std::vector<std::string>& names) {
  if (names.empty()) return stand.buses;
  std::vector<config::BusConfig> chosen;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(stand.buses, name, &config::BusConfig::name);
    if (found == stand.buses.end()) {
      std::vector<std::string> known;
      for (const config::BusConfig& bus : stand.buses) known.push_back(bus.name);
      throw UsageError(
          fmt::format("no bus '{}' in {}: {}", name, stand.file.string(), Suggestion(name, known)));
    }
    chosen.push_back(*found);
  }
  return chosen;
}

drivers::ScanOptions ScanOf(const Options& options, const config::BusConfig& bus) {
  drivers::ScanOptions scan{options.units, {}};
  for (const int baud : options.baud_rates)
    scan.settings.push_back({baud, bus.parity, bus.stop_bits});
  if (!IsSerial(bus)) scan.settings.clear();
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

// What is to be done about a line, one sentence or two each.
std::vector<std::string> AdviceOn(const LineReport& report) {
  std::vector<std::string> advice;
  const drivers::LineSetting own{report.bus.baud, report.bus.parity, report.bus.stop_bits};
  if (report.all_unreadable) {
    return {
        "Every unit number that was asked gives replies that cannot be read: the adapter hears "
        "what it sends itself (switch off its echo), or the line is disturbed."};
  }
  for (const FoundUnit& found : report.found) {
    if (found.identity.kind == UnitKind::kUnreadable) {
      advice.push_back(fmt::format(
          "Unit {}: do two devices have this number? Disconnect one, and give it another.",
          found.unit));
    } else if (!found.expected.empty() && IsSerial(report.bus) && !(found.setting == own)) {
      advice.push_back(fmt::format("{} (unit {}) is set to {}, the line to {}: change one of them.",
                                   found.expected, found.unit, Describe(found.setting),
                                   Describe(own)));
    } else if (!found.expected.empty() && !found.as_expected) {
      advice.push_back(
          fmt::format("Unit {} is to be {} and answers as {}: correct the unit numbers.",
                      found.unit, found.expected, NameOf(found.identity.kind)));
    }
  }
  for (const drivers::MissingUnit& missing : report.missing) {
    advice.push_back(
        fmt::format("{} (unit {}) does not answer: check its power, the cable, its unit number and "
                    "its baud rate.",
                    missing.device, missing.unit));
  }
  return advice;
}

presentation::Section SectionOf(const LineReport& report) {
  presentation::Section section;
  section.title = presentation::Strong(
      fmt::format("{}: {} unit numbers asked", drivers::DescribeBus(report.bus), report.asked));
  using Kind = presentation::Column::Kind;
  presentation::Table table{
      {{"unit", Kind::kCount}, {"answers as"}, {"stand file"}, {"its registers", Kind::kNote}}, {}};
  for (const FoundUnit& found : report.found) {
    if (report.all_unreadable) break;
    table.Add(
        {std::to_string(found.unit), NameText(found), StandFileText(found), found.identity.says});
  }
  Add(section.blocks, std::move(table));
  if (report.found.empty()) Add(section.blocks, presentation::Paragraph{"Nothing answers."});
  Add(section.blocks, presentation::ListOf(AdviceOn(report)));
  return section;
}

OrderedJson ToJson(const LineReport& report) {
  OrderedJson found = OrderedJson::array();
  for (const FoundUnit& one : report.found) {
    OrderedJson unit = {{"unit", one.unit},
                        {"kind", NameOf(one.identity.kind)},
                        {"model", one.identity.model},
                        {"registers", one.identity.says},
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
          {"as_expected", report.IsAsExpected()},
          {"advice", AdviceOn(report)}};
}

std::vector<LineReport> ScanAll(const config::StandConfig& stand, const Options& options) {
  const std::unique_ptr<Clock> clock = MakeSystemClock();
  const auto participant = clock->Join("devices");
  WorkBar bar(options.quiet);
  std::vector<LineReport> reports;
  for (const config::BusConfig& bus : ChosenBuses(stand, options.buses)) {
    reports.push_back(drivers::ScanLine(
        stand, bus, ScanOf(options, bus), *clock, *participant,
        [&bar](double fraction, const std::string& doing) { bar.Show(fraction, doing); }));
  }
  return reports;
}

}  // namespace

int Devices(const Options& options) {
  const BenchPlace bench(options.bench);
  const config::StandConfig stand = bench.Stand();
  if (stand.virtual_stand) {
    throw UsageError(fmt::format(
        "{} is a virtual stand, whose lines are the daemon's own. A virtual stand on lines of this "
        "machine is served by: gyrobench-stand --config {}",
        stand.file.string(), stand.file.string()));
  }
  RefuseBesideDaemon(bench);
  const std::vector<LineReport> reports = ScanAll(stand, options);
  const bool as_expected = std::ranges::all_of(reports, &LineReport::IsAsExpected);
  if (options.json) {
    OrderedJson lines = OrderedJson::array();
    for (const LineReport& report : reports) lines.push_back(ToJson(report));
    fmt::print("{}\n", JsonText(OrderedJson{{"format", "gyrobench.devices/1"},
                                            {"as_expected", as_expected},
                                            {"lines", lines}},
                                2));
  } else {
    presentation::Document document;
    for (const LineReport& report : reports) Add(document, SectionOf(report));
    fmt::print("{}", RenderText(document, presentation::DescribeTerminal(fileno(stdout))));
  }
  return as_expected ? kDone : kFailed;
}

}  // namespace gyrobench::cli
