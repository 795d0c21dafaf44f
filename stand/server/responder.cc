#include "stand/server/responder.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.h"
#include "config/stand_config.h"
#include "stand/server/modbus.h"

namespace gyrobench::stand {
Responder::Responder(const std::string& bus, Clock& clock, Utime start, const LineTiming& timing,
                     Faults& faults, std::uint64_t seed)
    : clock_(clock),
      start_(start),
      timing_(timing),
      faults_(faults),
      participant_(clock.Join("virtual bus " + bus, Clock::Role::kGuest)),
      garbage_(seed, Source::kGarbage) {
  station_of_unit_.fill(-1);
}

void Responder::Add(int unit, std::unique_ptr<Device> device) {
  if (unit < config::kFirstUnit || unit > config::kLastUnit) {
    throw ConfigError(fmt::format("virtual stand: {}: unit {}: expected {} .. {}", device->name(),
                                  unit, config::kFirstUnit, config::kLastUnit));
  }
  int& station = station_of_unit_[static_cast<std::size_t>(unit)];
  if (station >= 0) {
    throw ConfigError(fmt::format("virtual stand: {} and {} have the same unit {} on one bus",
                                  stations_[static_cast<std::size_t>(station)].device->name(),
                                  device->name(), unit));
  }
  station = static_cast<int>(stations_.size());
  stations_.push_back({.device = std::move(device)});
}

Responder::Answer Responder::Respond(std::uint8_t unit, std::span<const std::uint8_t> pdu,
                                     std::size_t request_size, std::size_t overhead,
                                     std::span<std::uint8_t> reply) {
  const int station = station_of_unit_[unit];
  if (station < 0) return {};
  Station& asked = stations_[static_cast<std::size_t>(station)];
  const Utime taken = clock_.Now() + timing_.Request(request_size);
  const AnswerFault fault = faults_.Requested(asked.device->name(), ToSeconds(taken - start_));
  if (fault.lost_power) asked.device->LosePower(taken);
  if (fault.silent || participant_->WaitUntil(taken)) return {};
  const Answer answer = Ask(asked, pdu, taken, fault, reply);
  if (participant_->WaitUntil(taken + FromSeconds(fault.late_s) +
                              timing_.Reply(answer.size + overhead))) {
    return {};
  }
  return answer;
}

Responder::Answer Responder::Ask(Station& asked, std::span<const std::uint8_t> pdu, Utime taken,
                                 const AnswerFault& fault, std::span<std::uint8_t> reply) {
  const std::size_t size = fault.exception != 0
                               ? RefusePdu(pdu, fault.exception, reply)
                               : AnswerPdu(*asked.device, pdu, taken, fault.impostor, reply);
  if (fault.garbage) return Garbage(reply);
  std::vector<std::uint8_t> now(reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(size));
  std::swap(now, asked.last_reply);
  if (!fault.stale) return {.size = size, .spoiled = fault.spoiled};
  std::ranges::copy(now, reply.begin());
  return {.size = now.size(), .spoiled = fault.spoiled, .stale = true};
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
