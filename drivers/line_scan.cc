#include "drivers/line_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <set>
#include <utility>

#include "drivers/modbus_bus.h"

namespace gyrobench::drivers {
namespace {

using Transport = config::BusConfig::Transport;

// Rates that drives, encoders and microcontrollers are sold with or set to.
constexpr std::array<int, 9> kUsualBauds = {9600,   19200,  38400,  57600,  115200,
                                            230400, 460800, 500000, 1000000};
// Of fewer unit numbers nothing can be said about the line.
constexpr int kLeastUnreadable = 3, kLeastAnswers = 10;

std::vector<LineSetting> UsualSettings(const config::BusConfig& bus) {
  std::vector<LineSetting> settings;
  if (bus.transport == Transport::kTcp) return settings;
  for (const int baud : kUsualBauds) {
    for (const LineSetting& setting : {LineSetting{baud, 'N', 1}, LineSetting{baud, 'E', 1},
                                       LineSetting{baud, 'O', 1}, LineSetting{baud, 'N', 2}}) {
      if (!(setting == SettingOf(bus))) settings.push_back(setting);
    }
  }
  return settings;
}

bool IsUnreadable(const FoundUnit& found) { return found.identity.kind == UnitKind::kUnreadable; }

class LineScan {
 public:
  LineScan(const config::StandConfig& stand, const config::BusConfig& bus,
           const ScanOptions& options, Clock& clock, Clock::Participant& participant,
           const ScanProgress& progress)
      : options_(options), clock_(clock), participant_(participant), progress_(progress) {
    report_.bus = bus;
    for (const config::BusConfig& one : stand.buses) {
      for (ExpectedUnit& unit : ExpectedOn(stand, one.name)) known_.push_back(std::move(unit));
    }
    on_line_ = ExpectedOn(stand, bus.name);
    for (const ExpectedUnit& unit : on_line_) {
      if (std::ranges::find(options.units, unit.unit) != options.units.end())
        expected_.push_back(unit);
    }
  }

  LineReport Run() {
    try {
      AskAtSettings();
      JudgeLine();
      if (options_.settings.empty() && !report_.all_unreadable) SeekUnheard();
    } catch (const LineClosed& error) {
      report_.error = error.what();
    } catch (const Stopped&) {
      report_.stopped = true;
    }
    for (const ExpectedUnit& unit : on_line_) {
      if (Answered(unit.unit)) continue;
      const bool silent = report_.error.empty() && asked_units_.contains(unit.unit);
      (silent ? report_.missing : report_.not_asked).push_back({unit.unit, unit.device, unit.kind});
    }
    std::ranges::stable_sort(report_.found, {}, &FoundUnit::unit);
    return std::move(report_);
  }

 private:
  struct Stopped {};

  bool Answered(int unit) const {
    return std::ranges::any_of(report_.found,
                               [unit](const FoundUnit& found) { return found.unit == unit; });
  }
  bool AnswersAtOwn(int unit) const {
    return std::ranges::any_of(report_.found, [&](const FoundUnit& found) {
      return found.unit == unit && report_.IsOwn(found.setting) && !IsUnreadable(found);
    });
  }

  void AskAtSettings() {
    std::vector<LineSetting> settings = options_.settings;
    if (settings.empty()) settings.push_back(SettingOf(report_.bus));
    to_ask_ = options_.units.size() * settings.size();
    // Its own first: what answers there is asked no more, as a part by USB that takes any rate.
    std::ranges::stable_sort(settings, std::greater<>(), [this](const LineSetting& setting) {
      return setting == SettingOf(report_.bus);
    });
    for (const LineSetting& setting : settings) AskAll(options_.units, setting);
  }

  // By the line's own setting, which a scan for others need not have.
  void JudgeLine() {
    const auto heard = std::ranges::count_if(
        report_.found, [this](const FoundUnit& found) { return report_.IsOwn(found.setting); });
    if (heard < report_.asked) return;
    const bool unreadable = std::ranges::all_of(report_.found, IsUnreadable);
    report_.all_unreadable = unreadable && report_.asked >= kLeastUnreadable;
    report_.all_answer = !unreadable && report_.asked >= kLeastAnswers;
  }

  // What is silent, or cannot be read, may be set otherwise.
  void SeekUnheard() {
    std::vector<int> unheard;
    for (const ExpectedUnit& expected : expected_) {
      if (!AnswersAtOwn(expected.unit)) unheard.push_back(expected.unit);
    }
    const std::vector<LineSetting> settings = UsualSettings(report_.bus);
    asked_ = 0;
    to_ask_ = unheard.size() * settings.size();
    for (const LineSetting& setting : settings) {
      if (unheard.empty()) return;
      AskAll(unheard, setting);
      std::erase_if(unheard, [&](int unit) {
        return std::ranges::any_of(report_.found, [&](const FoundUnit& found) {
          return found.unit == unit && found.setting == setting;
        });
      });
    }
  }

  void AskAll(const std::vector<int>& units, const LineSetting& setting) {
    config::BusConfig config = report_.bus;
    config.baud = setting.baud;
    config.parity = setting.parity;
    config.stop_bits = setting.stop_bits;
    config.retries = 0;
    const bool own = report_.IsOwn(setting);
    ModbusBus bus(config, clock_, participant_);
    for (const int unit : units) {
      const auto to_ask = static_cast<double>(std::max<std::size_t>(to_ask_, 1));
      if (!progress_(static_cast<double>(asked_++) / to_ask,
                     fmt::format("bus {}, {}, unit {}", config.name, Describe(setting), unit)))
        throw Stopped();
      if (!own && AnswersAtOwn(unit)) continue;
      const auto expected = std::ranges::find(expected_, unit, &ExpectedUnit::unit);
      const ExpectedUnit* device = expected != expected_.end() ? &*expected : nullptr;
      const UnitIdentity identity = Identify(bus, unit, device, known_);
      asked_units_.insert(unit);
      report_.asked = static_cast<int>(asked_units_.size());
      if (identity.kind == UnitKind::kSilent) continue;
      // That is what a device looks like that is set otherwise.
      if (identity.kind == UnitKind::kUnreadable && !own) continue;
      Add({.unit = unit, .setting = setting, .identity = identity}, device);
    }
  }

  // One that is heard at another setting was no other device at its own.
  void Add(FoundUnit found, const ExpectedUnit* expected) {
    std::erase_if(report_.found, [&](const FoundUnit& before) {
      return before.unit == found.unit && IsUnreadable(before);
    });
    if (expected != nullptr) {
      found.expected = expected->device;
      found.as_expected = found.identity.kind == expected->kind && found.identity.wrong.empty() &&
                          report_.IsOwn(found.setting);
    }
    report_.found.push_back(std::move(found));
  }

  // Of the stand; of this line; of these those to be asked.
  std::vector<ExpectedUnit> known_, on_line_, expected_;
  const ScanOptions& options_;
  Clock& clock_;
  Clock::Participant& participant_;
  const ScanProgress& progress_;
  LineReport report_;
  std::set<int> asked_units_;
  std::size_t asked_ = 0, to_ask_ = 0;
};

}  // namespace

std::string Describe(const LineSetting& setting) {
  return fmt::format("{} baud 8{}{}", setting.baud, setting.parity, setting.stop_bits);
}

LineSetting SettingOf(const config::BusConfig& bus) {
  return {bus.baud, bus.parity, bus.stop_bits};
}

bool LineReport::IsOwn(const LineSetting& setting) const {
  return bus.transport == Transport::kTcp || setting == SettingOf(bus);
}

bool LineReport::IsAsExpected() const {
  return error.empty() && !stopped && missing.empty() && !all_unreadable &&
         std::ranges::all_of(
             found, [](const FoundUnit& one) { return one.expected.empty() || one.as_expected; });
}

LineReport ScanLine(const config::StandConfig& stand, const config::BusConfig& bus,
                    const ScanOptions& options, Clock& clock, Clock::Participant& participant,
                    const ScanProgress& progress) {
  return LineScan(stand, bus, options, clock, participant, progress).Run();
}

}  // namespace gyrobench::drivers
