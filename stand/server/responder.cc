#include "stand/server/responder.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "stand/server/modbus.h"

namespace gyrobench::stand {
namespace {

using Kind = config::FaultScenario::Kind;

Utime TimeAt(Utime start, double t_s) {
  return std::isfinite(t_s) ? start + FromSeconds(t_s) : std::numeric_limits<Utime>::max();
}

}  // namespace

DeviceFaults::DeviceFaults(const config::Scenario& specimen, const std::string& device,
                           Utime start) {
  for (const auto& fault : specimen.faults) {
    if (fault.device != device) continue;
    Entry entry{.begin = TimeAt(start, fault.at_s),
                .end = TimeAt(start, fault.at_s + fault.duration_s),
                .kind = fault.kind};
    if (fault.kind == Kind::kReboot) {
      entry.end = TimeAt(start, fault.at_s + specimen.unit.boot_time_s);
    }
    if (fault.kind == Kind::kLate) entry.late = FromSeconds(fault.amount);
    entries_.push_back(entry);
  }
}

AnswerFault DeviceFaults::At(Utime at) const {
  AnswerFault fault;
  for (const Entry& entry : entries_) {
    if (at < entry.begin || at >= entry.end) continue;
    fault.silent |= entry.kind == Kind::kSilent || entry.kind == Kind::kReboot;
    fault.garbage |= entry.kind == Kind::kGarbage;
    fault.spoiled |= entry.kind == Kind::kBadCrc;
    fault.impostor |= entry.kind == Kind::kWrongIdentity;
    fault.late += entry.late;
  }
  return fault;
}

Responder::Responder(const std::string& bus, Clock& clock, const LineTiming& timing,
                     std::uint64_t seed)
    : clock_(clock),
      timing_(timing),
      participant_(clock.Join("virtual bus " + bus, Clock::Role::kGuest)),
      garbage_(seed, Source::kGarbage) {
  station_of_unit_.fill(-1);
}

void Responder::Add(int unit, std::unique_ptr<Device> device, DeviceFaults faults) {
  if (unit < 1 || unit > 247) {
    throw ConfigError(
        fmt::format("virtual stand: {}: unit {}: expected 1 .. 247", device->name(), unit));
  }
  int& station = station_of_unit_[static_cast<std::size_t>(unit)];
  if (station >= 0) {
    throw ConfigError(fmt::format("virtual stand: {} and {} have the same unit {} on one bus",
                                  stations_[static_cast<std::size_t>(station)].device->name(),
                                  device->name(), unit));
  }
  station = static_cast<int>(stations_.size());
  stations_.push_back({std::move(device), std::move(faults)});
}

Responder::Answer Responder::Respond(std::uint8_t unit, std::span<const std::uint8_t> pdu,
                                     std::size_t request_size, std::size_t overhead,
                                     std::span<std::uint8_t> reply) {
  const int station = station_of_unit_[unit];
  if (station < 0) return {};
  Station& asked = stations_[static_cast<std::size_t>(station)];
  const Utime taken = clock_.Now() + timing_.Request(request_size);
  const AnswerFault fault = asked.faults.At(taken);
  if (fault.silent || participant_->WaitUntil(taken)) return {};
  Answer answer{.size = AnswerPdu(*asked.device, pdu, taken, fault.impostor, reply),
                .spoiled = fault.spoiled};
  if (fault.garbage) answer = Garbage(reply);
  if (participant_->WaitUntil(taken + fault.late + timing_.Reply(answer.size + overhead)))
    return {};
  return answer;
}

Responder::Answer Responder::Garbage(std::span<std::uint8_t> reply) {
  constexpr std::size_t kShortest = 5, kSpread = 40;
  const std::size_t size = kShortest + garbage_.Bits() % kSpread;
  for (std::size_t i = 0; i < size; ++i) reply[i] = static_cast<std::uint8_t>(garbage_.Bits());
  return {.size = size, .garbage = true};
}

void Responder::FrameRejected() {
  for (Station& station : stations_) station.device->FrameRejected();
}

}  // namespace gyrobench::stand
