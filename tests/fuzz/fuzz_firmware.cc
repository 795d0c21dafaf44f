// libFuzzer target: the bytes are frames on the serial line of the gyro unit's firmware.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "stand/server/modbus.h"
#include "tests/firmware/parts.h"

namespace {

// What must hold whatever comes: a reply fits, is a sound frame of the unit's own number that says
// as many bytes as it has, and what can be written leaves the unit within its ranges.
class Firmware {
 public:
  Firmware() { unit_init(&unit_); }

  // A frame of these characters, damaged ones and all; `mends`: with a checksum that fits.
  void Take(std::span<const std::uint8_t> characters, bool mends) {
    receiver receiver;
    receiver_begin(&receiver);
    for (const std::uint8_t character : characters) receiver_take(&receiver, character, 1);
    if (mends) {
      const std::uint16_t checksum = gyrobench::stand::Crc16(characters);
      receiver_take(&receiver, static_cast<std::uint8_t>(checksum & 0xFF), 1);
      receiver_take(&receiver, static_cast<std::uint8_t>(checksum >> 8), 1);
    }
    const moment moment = {.tick = ++tick_, .next = unit_.ring.next};
    const std::uint8_t number = unit_.line.unit;
    const std::uint16_t size = slave_answer(&unit_, &receiver, &moment, reply_.data());
    if (size > 0) Judge(size, number);
    Require(unit_.settings.gyro_range <= 3 && unit_.settings.filter <= 6 &&
            unit_.settings.accel_range <= 3);
    Require(line_is_possible(&unit_.line_wanted) != 0);
    if (unit_.keep_line != 0) unit_.line = unit_.line_wanted;
    unit_.keep_line = 0;
  }

 private:
  static void Require(bool holds) {
    if (!holds) std::abort();
  }
  void Judge(std::uint16_t size, std::uint8_t number) const {
    Require(size >= 5 && size <= reply_.size());
    Require(gyrobench::stand::Crc16({reply_.data(), size}) == 0);
    Require(reply_[0] == number);
    const std::uint8_t function = reply_[1];
    if (function == 3 || function == 4) {
      Require(size == 5 + reply_[2] && reply_[2] % 2 == 0);
    } else {
      Require(size == (function >= 0x80 ? 5 : 8));
    }
  }

  unit unit_ = {};
  std::array<std::uint8_t, REPLY_SIZE> reply_ = {};
  std::uint32_t tick_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Firmware firmware;
  std::span<const std::uint8_t> left(data, size);
  while (!left.empty()) {
    const std::uint8_t head = left[0];  // length of the frame, and whether its checksum is mended
    const std::size_t length = std::min<std::size_t>(head & 0x7F, left.size() - 1);
    firmware.Take(left.subspan(1, length), (head & 0x80) != 0);
    left = left.subspan(1 + length);
  }
  return 0;
}
