#include "stand/faults.h"

#include <algorithm>
#include <array>

#include "stand/random.h"

namespace gyrobench::stand {
namespace {

using Mover = config::FaultScenario::Mover;
using On = config::FaultScenario::On;

constexpr std::array<std::string_view, 3> kAxisPrefixes = {"outer.", "middle.", "inner."};
constexpr int kDeviceFailure = 4;

bool IsMoverOf(const config::FaultScenario& fault, std::size_t axis) {
  if (fault.axis != Mover::kOwn) {
    return static_cast<std::size_t>(fault.axis) == axis + static_cast<std::size_t>(Mover::kOuter);
  }
  const auto is_of = [&](std::string_view prefix) { return fault.device.starts_with(prefix); };
  return std::ranges::none_of(kAxisPrefixes, is_of) || is_of(kAxisPrefixes[axis]);
}

// What is drawn anew for each request; all else is drawn once.
bool IsOfTheLine(Faults::Kind kind) {
  constexpr std::array kOfTheLine = {Faults::Kind::kSilent,       Faults::Kind::kGarbage,
                                     Faults::Kind::kBadCrc,       Faults::Kind::kLate,
                                     Faults::Kind::kStale,        Faults::Kind::kException,
                                     Faults::Kind::kWrongIdentity};
  return std::ranges::find(kOfTheLine, kind) != kOfTheLine.end();
}

// Uniform in [0, 1).
double Draw(std::uint64_t source_seed, std::int64_t number) {
  return static_cast<double>(Mix(source_seed ^ Mix(static_cast<std::uint64_t>(number) + 1)) >>
                             11U) *
         0x1p-53;
}

}  // namespace

Faults::Faults(const config::Scenario& specimen, std::uint64_t seed)
    : boot_time_s_(specimen.unit.boot_time_s) {
  for (const config::FaultScenario& fault : specimen.faults) {
    Entry entry{.fault = fault, .source_seed = SourceSeed(seed, Source::kFault, entries_.size())};
    const bool happens = IsOfTheLine(fault.kind) || Draw(entry.source_seed, 0) < fault.probability;
    if (!happens) continue;
    if (fault.on == On::kPowerOn) Begin(entry, 0.0);
    entries_.push_back(entry);
  }
}

void Faults::Begin(Entry& entry, double from_s) const {
  entry.begin_s = from_s + entry.fault.at_s;
  const bool reboot = entry.fault.kind == Kind::kReboot;
  entry.end_s = entry.begin_s + (reboot ? boot_time_s_ : entry.fault.duration_s);
}

void Faults::Moved(std::size_t axis, double t_s) {
  const std::lock_guard lock(mutex_);
  for (Entry& entry : entries_) {
    if (entry.fault.on != On::kMove || !IsMoverOf(entry.fault, axis)) continue;
    if (++entry.events == entry.fault.count) Begin(entry, t_s);
  }
}

bool Faults::Hits(const Entry& entry) {
  return !IsOfTheLine(entry.fault.kind) ||
         Draw(entry.source_seed, entry.requests) < entry.fault.probability;
}

AnswerFault Faults::Requested(std::string_view device, double t_s) {
  const std::lock_guard lock(mutex_);
  AnswerFault answer;
  for (Entry& entry : entries_) {
    if (entry.fault.device != device) continue;
    ++entry.requests;
    if (entry.fault.on == On::kRequest && entry.requests == entry.fault.count) Begin(entry, t_s);
    const bool reboot = entry.fault.kind == Kind::kReboot && t_s >= entry.begin_s;
    if (reboot && !entry.power_loss_told) answer.lost_power = entry.power_loss_told = true;
    if (entry.Acts(t_s) && Hits(entry)) Add(entry, answer);
  }
  return answer;
}

void Faults::Add(const Entry& entry, AnswerFault& answer) {
  const int code = static_cast<int>(entry.fault.amount);
  switch (entry.fault.kind) {
    case Kind::kSilent:
    case Kind::kReboot:
      answer.silent = true;
      break;
    case Kind::kGarbage:
      answer.garbage = true;
      break;
    case Kind::kBadCrc:
      answer.spoiled = true;
      break;
    case Kind::kLate:
      answer.late_s += entry.fault.amount;
      break;
    case Kind::kException:
      answer.exception = code != 0 ? code : kDeviceFailure;
      break;
    case Kind::kStale:
      answer.stale = true;
      break;
    case Kind::kWrongIdentity:
      answer.impostor = true;
      break;
    default:
      break;
  }
}

std::optional<double> Faults::Acting(std::string_view device, Kind kind, double t_s) const {
  if (entries_.empty()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  for (const Entry& entry : entries_) {
    if (entry.fault.kind == kind && entry.fault.device == device && entry.Acts(t_s)) {
      return entry.fault.amount;
    }
  }
  return std::nullopt;
}

std::optional<Faults::Begun> Faults::TakeBegun(double t_s) {
  if (entries_.empty()) return std::nullopt;
  const std::lock_guard lock(mutex_);
  Entry* first = nullptr;
  for (Entry& entry : entries_) {
    const bool due = !entry.taken && entry.begin_s <= t_s;
    if (due && (first == nullptr || entry.begin_s < first->begin_s)) first = &entry;
  }
  if (first == nullptr) return std::nullopt;
  first->taken = true;
  return Begun{.begin_s = first->begin_s, .end_s = first->end_s, .fault = first->fault};
}

}  // namespace gyrobench::stand
