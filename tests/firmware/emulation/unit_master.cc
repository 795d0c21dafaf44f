#include "tests/firmware/emulation/unit_master.h"

#include <algorithm>
#include <utility>

#include "stand/server/modbus.h"

namespace gyrobench::firmware {
namespace {

constexpr double kTimeout_s = 0.05;

void Put(std::vector<std::uint8_t>& out, int word) {
  out.push_back(static_cast<std::uint8_t>(word >> 8 & 0xFF));
  out.push_back(static_cast<std::uint8_t>(word & 0xFF));
}

void Close(std::vector<std::uint8_t>& frame) {
  const std::uint16_t crc = stand::Crc16(frame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
}

}  // namespace

std::optional<UnitMaster::Reply> UnitMaster::Read(int function, int address, int count,
                                                  Damage damage) {
  std::vector<std::uint8_t> pdu = {static_cast<std::uint8_t>(function)};
  Put(pdu, address);
  Put(pdu, count);
  return Ask(std::move(pdu), damage);
}

std::optional<UnitMaster::Reply> UnitMaster::WriteMany(int address,
                                                       std::span<const std::uint16_t> values) {
  std::vector<std::uint8_t> pdu = {16};
  Put(pdu, address);
  Put(pdu, static_cast<int>(values.size()));
  pdu.push_back(static_cast<std::uint8_t>(2 * values.size()));
  for (const std::uint16_t value : values) Put(pdu, value);
  return Ask(std::move(pdu));
}

double UnitMaster::Takes_s(std::size_t bytes) const {
  constexpr double kSilence = 3.5;
  return (static_cast<double>(bytes) + kSilence) * Character_s();
}

void UnitMaster::WaitToComplete(std::size_t bytes, double t_s) {
  unit_.RunUntil(std::max(t_s - Takes_s(bytes), unit_.now_s()));
}

void UnitMaster::Send(std::vector<std::uint8_t> frame, Damage damage) {
  if (damage == Damage::kRequestFlipped) frame[frame.size() / 2] ^= 0x10;
  if (damage == Damage::kRequestCut) frame.resize(frame.size() - 3);
  if (damage == Damage::kRequestParted) {
    const auto half = static_cast<std::ptrdiff_t>(frame.size() / 2);
    unit_.Send({frame.data(), frame.size() / 2}, baud_);
    unit_.RunUntil(unit_.now_s() + (static_cast<double>(half) + 10.0) * Character_s());
    frame.erase(frame.begin(), frame.begin() + half);
  }
  unit_.Send(frame, baud_);
  request_complete_s_ = unit_.now_s() + Takes_s(frame.size());
}

std::optional<UnitMaster::Reply> UnitMaster::Ask(std::vector<std::uint8_t> pdu, Damage damage) {
  const std::uint8_t function = pdu.front();
  pdu.insert(pdu.begin(), static_cast<std::uint8_t>(number_));
  Close(pdu);
  unit_.TakeSent();
  Send(std::move(pdu), damage);
  // The longest reply takes 255 characters.
  std::vector<EmulatedUnit::Byte> bytes;
  const double silence_s = 4.0 * Character_s();
  const double give_up_s = request_complete_s_ + kTimeout_s;
  for (double at_s = request_complete_s_; at_s < give_up_s; at_s += silence_s) {
    unit_.RunUntil(at_s);
    const auto more = unit_.TakeSent();
    bytes.insert(bytes.end(), more.begin(), more.end());
    if (!bytes.empty() && at_s > bytes.back().end_s + silence_s) break;
  }
  if (damage == Damage::kReplyLost || bytes.size() < 5) return std::nullopt;
  std::vector<std::uint8_t> frame;
  for (const EmulatedUnit::Byte& byte : bytes) frame.push_back(byte.value);
  if (damage == Damage::kReplyFlipped) frame[frame.size() / 2] ^= 0x04;
  if (stand::Crc16(frame) != 0 || frame[0] != number_ || (frame[1] & 0x7F) != function)
    return std::nullopt;
  Reply reply;
  reply.end_s = bytes.back().end_s;
  if ((frame[1] & 0x80) != 0) {
    reply.exception = frame[2];
  } else if (function == 3 || function == 4) {
    for (std::size_t i = 3; i + 3 < frame.size(); i += 2)
      reply.words.push_back(static_cast<std::uint16_t>(frame[i] << 8 | frame[i + 1]));
  }
  return reply;
}

}  // namespace gyrobench::firmware
