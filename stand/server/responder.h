// The devices of one line, and when and how they answer.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/clock.h"
#include "stand/devices/device.h"
#include "stand/faults.h"
#include "stand/random.h"
#include "stand/server/line.h"

namespace gyrobench::stand {

// Used by the line's server thread alone, but for Stop.
class Responder {
 public:
  struct Answer {
    std::size_t size = 0;  // of the PDU; 0: silence
    bool garbage = false;  // `size` random bytes without a frame around them
    bool spoiled = false;  // the frame's check must be wrong
    bool stale = false;    // it answers the request before
  };

  // Power-on was at `start`; clock and faults must outlive the responder.
  Responder(const std::string& bus, Clock& clock, Utime start, const LineTiming& timing,
            Faults& faults, std::uint64_t seed);
  void Add(int unit, std::unique_ptr<Device> device);

  // Waits for the time that the request takes on the line, asks the device, waits until the reply
  // is through. `request_size`: bytes of the whole frame; `overhead`: bytes that frame a PDU.
  Answer Respond(std::uint8_t unit, std::span<const std::uint8_t> pdu, std::size_t request_size,
                 std::size_t overhead, std::span<std::uint8_t> reply);
  // A frame on the line was damaged.
  void FrameRejected();
  // Ends a wait in Respond, from another thread.
  void Stop() { participant_->Notify(); }

 private:
  struct Station {
    std::unique_ptr<Device> device;
    std::vector<std::uint8_t> last_reply = {};
  };
  Answer Ask(Station& asked, std::span<const std::uint8_t> pdu, Utime taken,
             const AnswerFault& fault, std::span<std::uint8_t> reply);
  Answer Garbage(std::span<std::uint8_t> reply);

  Clock& clock_;
  Utime start_;
  LineTiming timing_;
  Faults& faults_;
  std::unique_ptr<Clock::Participant> participant_;
  RandomStream garbage_;
  std::vector<Station> stations_;
  std::array<int, 256> station_of_unit_;
};

}  // namespace gyrobench::stand
