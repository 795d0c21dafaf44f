// How long frames take on a line.
#pragma once

#include "base/clock.h"
#include "config/scenario.h"
#include "config/stand_config.h"

namespace gyrobench::stand {

// RTU: a character is a start bit, 8 data bits, parity and stop bits at the line's baud; a frame
// ends with 3.5 characters of silence, and there the device takes the request. TCP: a fixed latency
// each way.
//   transaction = request + silence + turnaround + reply
class LineTiming {
 public:
  LineTiming(const config::BusConfig& bus, const config::BusScenario& scenario)
      : rtu_(bus.transport == config::BusConfig::Transport::kRtu),
        character_s_((9.0 + (bus.parity == 'N' ? 0.0 : 1.0) + bus.stop_bits) / bus.baud),
        turnaround_s_(scenario.turnaround_s),
        tcp_latency_s_(scenario.tcp_latency_s) {}

  // From the first byte written to the device's having the request.
  Utime Request(std::size_t bytes) const {
    return FromSeconds(rtu_ ? (static_cast<double>(bytes) + kSilence) * character_s_
                            : tcp_latency_s_);
  }
  // From there to the last byte of the reply.
  Utime Reply(std::size_t bytes) const {
    return FromSeconds(turnaround_s_ +
                       (rtu_ ? static_cast<double>(bytes) * character_s_ : tcp_latency_s_));
  }

 private:
  static constexpr double kSilence = 3.5;
  bool rtu_;
  double character_s_, turnaround_s_, tcp_latency_s_;
};

}  // namespace gyrobench::stand
