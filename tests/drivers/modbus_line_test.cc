// The line below a bus: connections, serial devices, checksums and the time on the wire.
#include "drivers/modbus_line.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <string>

#include "tests/drivers/bus_bench.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(ModbusTcp, ADroppedConnectionIsMadeAnew) {
  BusBench bench(Transport::kTcp);
  EXPECT_THAT(bench.Read(), kGood);
  bench.line.Inject(LineFault::kDisconnect);
  EXPECT_THAT(bench.Read(), kGood);
  EXPECT_EQ(bench.bus->statistics().connections, 2);
}

TEST(ModbusTcp, AServerThatWentAwayEndsInAnErrorThatNamesItsAddress) {
  BusBench bench(Transport::kTcp);
  EXPECT_THAT(bench.Read(), kGood);
  bench.line.Unplug();
  const Utime start = bench.clock.Now();
  EXPECT_THAT(bench.ReadFailure(),
              AllOf(HasSubstr("127.0.0.1:" + std::to_string(bench.line.Config().port)),
                    HasSubstr("2 tries"), HasSubstr("server is running")));
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("refused"));
  EXPECT_LE(bench.clock.Now() - start, 6 * kTimeout_us);
}

TEST(ModbusTcp, ARefusedConnectionIsAnErrorAtOnce) {
  BusBench bench(Transport::kTcp, 5);
  bench.line.Unplug();
  EXPECT_THAT(bench.ReadFailure(), AllOf(HasSubstr("axis.inner drive"), HasSubstr("refused"),
                                         HasSubstr("127.0.0.1"), HasSubstr("1 try")));
}

TEST(ModbusRtu, AMissingSerialDeviceIsAnErrorThatNamesIt) {
  ManualClock clock;
  const auto participant = clock.Join("bus", Clock::Role::kResident);
  config::BusConfig config;
  config.name = "A";
  config.device = testing::TempDir() + "no-such-tty";
  ModbusBus bus(config, clock, *participant);
  std::array<std::uint16_t, 1> value = {};
  try {
    bus.ReadHolding(kUnit, 1, value, "status");
    FAIL() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(config.device), HasSubstr("No such file"),
                                    HasSubstr("plugged in"), HasSubstr("1 try")));
  }
}

// Of another daemon, say, that was started while the adapter was not plugged in.
TEST(ModbusRtu, ALineThatAnotherHasLockedIsNotUsedAndOneInUseIsLocked) {
  BusBench bench(Transport::kRtu);
  const int other = ::open(bench.line.Config().device.c_str(), O_RDWR | O_NOCTTY);
  ASSERT_GE(other, 0);
  ASSERT_EQ(::flock(other, LOCK_EX | LOCK_NB), 0);
  EXPECT_THAT(bench.ReadFailure(), AllOf(HasSubstr("another process has locked it"),
                                         HasSubstr(bench.line.Config().device)));
  EXPECT_TRUE(bench.line.requests().empty());
  ASSERT_EQ(::flock(other, LOCK_UN), 0);
  EXPECT_THAT(bench.Read(), kGood);
  EXPECT_NE(::flock(other, LOCK_EX | LOCK_NB), 0);
  bench.bus.reset();
  EXPECT_EQ(::flock(other, LOCK_EX | LOCK_NB), 0);
  ::close(other);
}

TEST(ModbusRtu, AnAdapterPulledOutEndsInAnError) {
  BusBench bench(Transport::kRtu);
  EXPECT_THAT(bench.Read(), kGood);
  bench.line.Unplug();
  EXPECT_THAT(bench.ReadFailure(), HasSubstr(bench.line.Config().device));
}

TEST(ModbusRtu, ARateThatWouldSilentlyBecome9600IsRefused) {
  ManualClock clock;
  const auto participant = clock.Join("bus", Clock::Role::kResident);
  config::BusConfig config;
  for (const int baud : {250000, 2000000, 0, 115201}) {
    config.baud = baud;
    EXPECT_THROW(ModbusBus(config, clock, *participant), ConfigError) << baud;
  }
}

// hardware.md: the vendor's own example of this frame ends in DD 7B, which is wrong.
TEST(ModbusRtu, FramesEndInTheChecksumOfTheStandard) {
  BusBench bench(Transport::kRtu);
  RegisterUnit one;
  bench.line.Connect(1, one);
  bench.bus->WriteRegister({"drive", 1}, 0x0191, 0x0020, "peak current");
  EXPECT_THAT(bench.line.requests().back(),
              ElementsAre(0x01, 0x06, 0x01, 0x91, 0x00, 0x20, 0xD8, 0x03));
  // The law of the CRC: a frame with its checksum has checksum 0.
  for (const Bytes& request : bench.line.requests()) EXPECT_EQ(ModbusCrc(request), 0);
}

TEST(WireTime, IsTheNumberOfBitsOverTheRate) {
  config::BusConfig bus;
  for (const int baud : {9600, 115200, 500000}) {
    for (const char parity : {'N', 'E', 'O'}) {
      for (const int stop_bits : {1, 2}) {
        bus.baud = baud;
        bus.parity = parity;
        bus.stop_bits = stop_bits;
        const double bits = 9.0 + (parity == 'N' ? 0 : 1) + stop_bits;
        EXPECT_NEAR(static_cast<double>(WireTime(bus, 245)), 245 * bits / baud * 1e6, 0.5);
        EXPECT_NEAR(static_cast<double>(FrameGap(bus)), 3.5 * bits / baud * 1e6, 0.5);
      }
    }
  }
  // hardware.md: 12 samples of 10 registers at 115200 8N1 take about 23 ms with their request.
  bus = {};
  EXPECT_NEAR(static_cast<double>(WireTime(bus, 5 + 240 + 8)), 22e3, 1e3);
  bus.transport = Transport::kTcp;
  EXPECT_EQ(WireTime(bus, 245), 0);
}

// 8 bytes of request and 3.5 characters of silence at 115200 8N1: 11.5 * 10 bits = 998 us.
TEST(ModbusRtu, TheDeviceTookTheRequestWhenItsFrameHadEnded) {
  BusBench bench(Transport::kRtu);
  bench.Read();
  EXPECT_NEAR(static_cast<double>(bench.timing.utime_latched - bench.timing.utime_request), 998, 1);
}

// A slow line needs longer than the response timeout for the frames alone.
TEST(ModbusRtu, TheDeadlineAllowsForTheTimeOnTheWire) {
  FakeLine line(Transport::kRtu);
  ManualClock clock;
  const auto participant = clock.Join("bus", Clock::Role::kResident);
  line.SetDelay([&](Utime duration_us) { clock.Advance(duration_us); });
  RegisterUnit unit;
  unit.SetHolding(0, Words(120, 1));
  line.Connect(5, unit);
  config::BusConfig config = line.Config();
  config.baud = 9600;
  config.retries = 0;
  ModbusBus bus(config, clock, *participant);
  std::array<std::uint16_t, 120> values = {};
  const Utime wire_us = WireTime(config, 8 + 245);
  line.Inject(LineFault::kLate, static_cast<int>(wire_us + kTimeout_us - 1));
  EXPECT_NO_THROW(bus.ReadHolding(kUnit, 0, values, "block"));
  line.Inject(LineFault::kLate, static_cast<int>(wire_us + kTimeout_us + 2));
  EXPECT_THROW(bus.ReadHolding(kUnit, 0, values, "block"), DeviceError);
}

}  // namespace
}  // namespace gyrobench::drivers
