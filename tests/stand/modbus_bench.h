// A client of the virtual stand's Modbus for tests.
#pragma once

#include <gtest/gtest.h>
#include <modbus/modbus.h>

#include <array>
#include <cerrno>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "stand/virtual_stand.h"
#include "tests/stand/test_stand.h"

namespace gyrobench::stand {
using Kind = config::FaultScenario::Kind;
using Transport = config::BusConfig::Transport;

inline constexpr int kDrive = 3, kEncoder = 13, kGyro = 21, kNobody = 9;
inline constexpr std::uint16_t kInputs = 0x0100;  // of the drives

struct Closer {
  void operator()(modbus_t* context) const {
    modbus_close(context);
    modbus_free(context);
  }
};

// A client of one bus, on a virtual clock of which it is the one resident.
class Bench {
 public:
  explicit Bench(Transport transport = Transport::kRtu,
                 std::vector<config::FaultScenario> faults = {},
                 config::Scenario scenario = config::IdealScenario())
      : clock_(MakeVirtualClock(kStart)), me_(clock_->Join("test")) {
    config::StandConfig config = TestStand();
    for (auto& axis : config.axes) {
      axis.drive.bus = axis.encoder.bus = "all";
      axis.drive.map.inputs = config::DriveInputs{
          .address = kInputs, .emergency_stop_bit = 0, .limit_plus_bit = 1, .limit_minus_bit = 2};
    }
    config.gyro.bus = "all";
    scenario.faults = std::move(faults);
    scenario.bus.turnaround_s = 0.0005;
    stand_ = std::make_unique<VirtualStand>(config, scenario, 1, *clock_);
    config::BusConfig bus;
    bus.name = "all";
    bus.transport = transport;
    const config::BusConfig served = stand_->Serve(bus);
    device_ = served.device;
    context_.reset(transport == Transport::kRtu
                       ? modbus_new_rtu(served.device.c_str(), 115200, 'N', 8, 1)
                       : modbus_new_tcp(served.host.c_str(), served.port));
    modbus_set_response_timeout(context_.get(), 1, 0);
    if (modbus_connect(context_.get()) != 0) throw std::runtime_error(modbus_strerror(errno));
  }

  // Until the client's time of silence is over, in real time.
  void ExpectSilence() { modbus_set_response_timeout(context_.get(), 0, 100'000); }
  void WaitUntil(double t_s) { me_->WaitUntil(At(t_s)); }
  double Now_s() const { return ToSeconds(clock_->Now() - kStart); }

  // nullopt: no reply, or an unusable one; see errno.
  template <std::size_t N>
  std::optional<std::array<std::uint16_t, N>> Read(int unit, int function, int address) {
    std::array<std::uint16_t, N> words = {};
    modbus_set_slave(context_.get(), unit);
    modbus_flush(context_.get());
    const int count = function == 3
                          ? modbus_read_registers(context_.get(), address, N, words.data())
                          : modbus_read_input_registers(context_.get(), address, N, words.data());
    if (count != static_cast<int>(N)) return std::nullopt;
    return words;
  }
  bool Write(int unit, int address, std::vector<std::uint16_t> words) {
    modbus_set_slave(context_.get(), unit);
    const int count = static_cast<int>(words.size());
    if (count == 1) return modbus_write_register(context_.get(), address, words[0]) == 1;
    return modbus_write_registers(context_.get(), address, count, words.data()) == count;
  }
  double Angle_deg() {
    const auto words = Read<2>(kEncoder, 3, 0).value();
    const auto counts = static_cast<std::int32_t>(std::uint32_t{words[0]} << 16U | words[1]);
    return counts * 360.0 / (1 << 20);
  }
  std::int32_t Position() {
    const auto words = Read<2>(kDrive, 3, 0x602A).value();
    return static_cast<std::int32_t>(std::uint32_t{words[0]} << 16U | words[1]);
  }
  bool Enable() { return Write(kDrive, 0x000F, {1}); }
  bool Move(std::int32_t pulses, std::uint16_t rpm = 100, std::uint16_t mode = 0x41) {
    const auto bits = static_cast<std::uint32_t>(pulses);
    return Write(kDrive, 0x6200, {mode, High(bits), Low(bits), rpm, 100, 100, 0, 0x0010});
  }
  static std::uint16_t High(std::uint32_t v) { return static_cast<std::uint16_t>(v >> 16U); }
  static std::uint16_t Low(std::uint32_t v) { return static_cast<std::uint16_t>(v & 0xFFFF); }

  modbus_t* context() { return context_.get(); }
  VirtualStand& stand() { return *stand_; }

 private:
  std::unique_ptr<VirtualClock> clock_;
  std::unique_ptr<Clock::Participant> me_;
  std::unique_ptr<VirtualStand> stand_;
  std::string device_;
  std::unique_ptr<modbus_t, Closer> context_;
};

// Both transports, for suites that hold for either.
class ServerTest : public testing::TestWithParam<Transport> {};
inline std::string TransportName(const testing::TestParamInfo<Transport>& test) {
  return test.param == Transport::kRtu ? "Rtu" : "Tcp";
}

}  // namespace gyrobench::stand
