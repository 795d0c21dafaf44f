// The devices of one line, and when and how they answer.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "base/clock.h"
#include "config/scenario.h"
#include "stand/devices/device.h"
#include "stand/random.h"
#include "stand/server/line.h"

namespace gyrobench::stand {

// What the line's faults make of a device's answer.
struct AnswerFault {
  bool silent = false, garbage = false, spoiled = false, impostor = false;
  Utime late = 0;
};

// The faults of one device, by time.
class DeviceFaults {
 public:
  DeviceFaults(const config::Scenario& specimen, const std::string& device, Utime start);
  AnswerFault At(Utime at) const;

 private:
  struct Entry {
    Utime begin = 0, end = 0;
    config::FaultScenario::Kind kind;
    Utime late = 0;
  };
  std::vector<Entry> entries_;
};

// Used by the line's server thread alone, but for Stop.
class Responder {
 public:
  struct Answer {
    std::size_t size = 0;  // of the PDU; 0: silence
    bool garbage = false;  // `size` random bytes without a frame around them
    bool spoiled = false;  // the frame's check must be wrong
  };

  Responder(const std::string& bus, Clock& clock, const LineTiming& timing, std::uint64_t seed);
  void Add(int unit, std::unique_ptr<Device> device, DeviceFaults faults);

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
    DeviceFaults faults;
  };
  Answer Garbage(std::span<std::uint8_t> reply);

  Clock& clock_;
  LineTiming timing_;
  std::unique_ptr<Clock::Participant> participant_;
  RandomStream garbage_;
  std::vector<Station> stations_;
  std::array<int, 256> station_of_unit_;
};

}  // namespace gyrobench::stand
