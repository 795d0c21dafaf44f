// Asks the emulated unit over its line, as a host does.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/firmware/emulation/emulated_unit.h"

namespace gyrobench::firmware {

// What happens to a frame on its way.
enum class Damage {
  kNone,
  kRequestFlipped,  // a bit of it
  kRequestCut,      // its last bytes are missing
  kRequestParted,   // a pause of 10 characters in it
  kReplyFlipped,
  kReplyLost,
};

// One request after the other; a reply is waited for 50 ms after the request's end.
class UnitMaster {
 public:
  struct Reply {
    std::vector<std::uint16_t> words;  // of a read
    int exception = 0;
    double end_s = 0.0;  // of its last byte
  };

  explicit UnitMaster(EmulatedUnit& unit, int baud = 115200, int number = 21)
      : unit_(unit), baud_(baud), number_(number) {}

  std::optional<Reply> Read(int function, int address, int count, Damage damage = Damage::kNone);
  std::optional<Reply> WriteMany(int address, std::span<const std::uint16_t> values);
  // Any PDU. Nothing where no sound reply of this unit came.
  std::optional<Reply> Ask(std::vector<std::uint8_t> pdu, Damage damage = Damage::kNone);
  // When the last request was complete: 3.5 characters behind its end.
  double request_complete_s() const { return request_complete_s_; }
  // Lets time pass until a request of so many bytes, begun then, is complete at `t_s`.
  void WaitToComplete(std::size_t bytes, double t_s);

 private:
  double Character_s() const { return 10.0 / baud_; }
  // Of a request, with the silence that ends it.
  double Takes_s(std::size_t bytes) const;
  void Send(std::vector<std::uint8_t> frame, Damage damage);

  EmulatedUnit& unit_;
  int baud_, number_;
  double request_complete_s_ = 0.0;
};

}  // namespace gyrobench::firmware
