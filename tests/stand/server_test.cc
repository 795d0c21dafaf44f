// The stand behind Modbus, asked by libmodbus as the drivers do.
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <memory>
#include <optional>

#include "base/error.h"
#include "stand/virtual_stand.h"
#include "tests/stand/test_stand.h"

namespace gyrobench::stand {
namespace {

using Kind = config::FaultScenario::Kind;
using Transport = config::BusConfig::Transport;

constexpr int kDrive = 3, kEncoder = 13, kGyro = 21, kNobody = 9;

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
    for (auto& axis : config.axes) axis.drive.bus = axis.encoder.bus = "all";
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

class ServerTest : public testing::TestWithParam<Transport> {};
INSTANTIATE_TEST_SUITE_P(Transports, ServerTest, testing::Values(Transport::kRtu, Transport::kTcp),
                         [](const auto& test) {
                           return test.param == Transport::kRtu ? "Rtu" : "Tcp";
                         });

TEST_P(ServerTest, SeveralUnitsAnswerOnOneLineEachWithItsOwnRegisters) {
  Bench bench(GetParam());
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x0001).value()[0], 10000);
  EXPECT_EQ(bench.Read<1>(kGyro, 4, 0x0000).value()[0], 0x4742);
  EXPECT_NEAR(bench.Angle_deg(), 0.0, 1e-3);
  EXPECT_EQ(bench.Read<1>(1, 3, 0x0001).value()[0], 10000);
}

TEST_P(ServerTest, AMoveInOneFrameTurnsTheTableAndTheEncoderSeesIt) {
  Bench bench(GetParam());
  ASSERT_TRUE(bench.Enable());
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0], 0x0032);  // enabled, at rest
  ASSERT_TRUE(bench.Move(20000));
  bench.WaitUntil(0.5);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0], 0x0006);  // enabled, moving
  bench.WaitUntil(5.0);
  EXPECT_EQ(bench.Position(), 20000);
  EXPECT_NEAR(bench.Angle_deg(), 18.0, 1e-3);
  ASSERT_TRUE(bench.Move(-5000, 100, 0x0001));  // absolute
  bench.WaitUntil(15.0);
  EXPECT_NEAR(bench.Angle_deg(), -4.5, 1e-3);
}

TEST_P(ServerTest, AQuickStopEndsAMotionAtOnce) {
  Bench bench(GetParam());
  bench.Enable();
  bench.Move(400000);
  bench.WaitUntil(1.0);
  ASSERT_TRUE(bench.Write(kDrive, 0x6002, {0x0040}));
  bench.WaitUntil(1.1);
  const std::int32_t stopped = bench.Position();
  bench.WaitUntil(10.0);
  EXPECT_EQ(bench.Position(), stopped);
  EXPECT_NEAR(stopped, 16000, 1500);
}

TEST_P(ServerTest, ADriveThatIsNotEnabledDoesNotMove) {
  Bench bench(GetParam());
  EXPECT_TRUE(bench.Move(20000));
  bench.WaitUntil(5.0);
  EXPECT_EQ(bench.Position(), 0);
}

TEST_P(ServerTest, WhatADeviceDoesNotHaveIsRefusedWithTheRightException) {
  Bench bench(GetParam());
  EXPECT_FALSE(bench.Read<1>(kDrive, 3, 0x7777));
  EXPECT_EQ(errno, EMBXILADD);
  EXPECT_FALSE(bench.Read<1>(kDrive, 4, 0x1003));
  EXPECT_EQ(errno, EMBXILFUN);
  EXPECT_FALSE(bench.Move(100, 5000));  // rpm
  EXPECT_EQ(errno, EMBXILVAL);
  EXPECT_FALSE(bench.Move(100, 100, 0x0002));  // velocity mode
  EXPECT_EQ(errno, EMBXILVAL);
  EXPECT_FALSE(bench.Write(kGyro, 0x0100, {9}));
  EXPECT_EQ(errno, EMBXILVAL);
  std::uint8_t coil = 0;
  EXPECT_EQ(modbus_read_bits(bench.context(), 0, 1, &coil), -1);
  EXPECT_EQ(errno, EMBXILFUN);
}

TEST_P(ServerTest, NobodyAnswersForAUnitThatIsNotThere) {
  Bench bench(GetParam());
  bench.ExpectSilence();
  EXPECT_FALSE(bench.Read<1>(kNobody, 3, 1));
  EXPECT_EQ(errno, ETIMEDOUT);
}

TEST_P(ServerTest, ABlockOfSamplesCanBeReadAgainAndIsTheSame) {
  Bench bench(GetParam());
  bench.WaitUntil(0.1);
  const auto first = bench.Read<120>(kGyro, 4, 0x4000 + 3).value();
  const auto again = bench.Read<120>(kGyro, 4, 0x4000 + 3).value();
  EXPECT_EQ(first[5], 3);
  for (std::size_t i = 4; i < 120; ++i) EXPECT_EQ(first[i], again[i]);
}

TEST_P(ServerTest, ABlockBeginsWithTheOldestSampleWhenTheWantedOneIsGone) {
  Bench bench(GetParam());
  bench.WaitUntil(10.0);
  const auto block = bench.Read<24>(kGyro, 4, 0x4000).value();
  EXPECT_EQ(block[3] - block[5], 64);
  EXPECT_EQ(block[8], 0);
  EXPECT_EQ(block[16], 1250);  // ticks from one sample to the next
}

TEST_P(ServerTest, ABlockOfSamplesThatAreNotThereYetIsEmpty) {
  Bench bench(GetParam());
  bench.WaitUntil(1.0);
  const auto block = bench.Read<24>(kGyro, 4, 0x4000 + 500).value();
  EXPECT_EQ(block[5], block[3]);
  for (std::size_t i = 8; i < block.size(); ++i) EXPECT_EQ(block[i], 0);
}

TEST_P(ServerTest, SettingsReadBackAndEmptyTheRing) {
  Bench bench(GetParam());
  bench.WaitUntil(1.0);
  ASSERT_TRUE(bench.Write(kGyro, 0x0100, {1, 2, 9, 3}));
  const auto settings = bench.Read<4>(kGyro, 3, 0x0100).value();
  EXPECT_EQ(settings, (std::array<std::uint16_t, 4>{1, 2, 9, 3}));
  EXPECT_EQ(bench.Read<1>(kGyro, 4, 0x0009).value()[0], 100);
  const auto block = bench.Read<16>(kGyro, 4, 0x4000).value();
  EXPECT_LE(block[3] - block[5], 1);
}

// Request, 3.5 characters of silence, turnaround, reply.
TEST(ServerTime, ATransactionTakesTheTimeOfItsBytesOnTheWire) {
  Bench bench(Transport::kRtu);
  bench.WaitUntil(1.0);
  const double character_s = 10.0 / 115200;
  bench.Read<2>(kEncoder, 3, 0).value();
  EXPECT_NEAR(bench.Now_s() - 1.0, (8 + 3.5 + 5 + 4) * character_s + 0.0005, 2e-6);
  bench.WaitUntil(2.0);
  bench.Read<120>(kGyro, 4, 0x4000).value();
  EXPECT_NEAR(bench.Now_s() - 2.0, (8 + 3.5 + 5 + 240) * character_s + 0.0005, 2e-6);
}

TEST(ServerTime, ADeviceTakesTheRequestAfterTheSilenceThatEndsIt) {
  Bench bench(Transport::kRtu);
  bench.WaitUntil(1.0);
  const auto block = bench.Read<8>(kGyro, 4, 0x4000).value();
  const double tick_s = (block[0] * 65536.0 + block[1]) / 250000;
  EXPECT_NEAR(tick_s, 1.0 + (8 + 3.5) * 10.0 / 115200, 8e-6);
}

TEST(ServerTime, OverTcpATransactionTakesTwoLatenciesAndTheTurnaround) {
  Bench bench(Transport::kTcp);
  bench.WaitUntil(1.0);
  bench.Read<2>(kEncoder, 3, 0).value();
  EXPECT_NEAR(bench.Now_s() - 1.0, 2 * 0.0003 + 0.0005, 2e-6);
}

TEST(ServerFrames, AFrameWithAWrongChecksumIsIgnoredAndCounted) {
  Bench bench(Transport::kRtu);
  const std::array<std::uint8_t, 8> damaged = {kGyro, 4, 0, 0, 0, 1, 0xDE, 0xAD};
  ASSERT_EQ(::write(modbus_get_socket(bench.context()), damaged.data(), damaged.size()), 8);
  bench.ExpectSilence();
  std::array<std::uint8_t, 260> reply;
  EXPECT_EQ(modbus_receive_confirmation(bench.context(), reply.data()), -1);
  EXPECT_EQ(errno, ETIMEDOUT);
  EXPECT_EQ(bench.Read<2>(kGyro, 4, 0x0014).value()[1], 1);
}

TEST(ServerFrames, TheRestOfAFrameThatNeverComesIsForgotten) {
  Bench bench(Transport::kRtu);
  const std::array<std::uint8_t, 3> torn = {kGyro, 4, 0};
  ASSERT_EQ(::write(modbus_get_socket(bench.context()), torn.data(), torn.size()), 3);
  bench.ExpectSilence();
  std::array<std::uint8_t, 260> reply;
  EXPECT_EQ(modbus_receive_confirmation(bench.context(), reply.data()), -1);
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
}

TEST(ServerFrames, ABroadcastIsIgnored) {
  Bench bench(Transport::kRtu);
  const std::array<std::uint8_t, 6> request = {0, 6, 0x00, 0x0F, 0x00, 0x01};
  modbus_set_slave(bench.context(), 0);
  modbus_send_raw_request(bench.context(), request.data(), request.size());
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x000F).value()[0], 0);
}

config::FaultScenario Fault(Kind kind, const char* device, double amount = 0.0) {
  return {.at_s = 1.0, .duration_s = 1.0, .device = device, .kind = kind, .amount = amount};
}

TEST_P(ServerTest, ASilentDeviceAnswersBeforeAndAfterItsFaultAndTheOthersAllTheTime) {
  Bench bench(GetParam(), {Fault(Kind::kSilent, "inner.encoder")});
  EXPECT_TRUE(bench.Read<2>(kEncoder, 3, 0));
  bench.WaitUntil(1.5);
  EXPECT_TRUE(bench.Read<1>(kDrive, 3, 1));
  bench.ExpectSilence();
  EXPECT_FALSE(bench.Read<2>(kEncoder, 3, 0));
  EXPECT_EQ(errno, ETIMEDOUT);
  bench.WaitUntil(2.5);
  EXPECT_TRUE(bench.Read<2>(kEncoder, 3, 0));
}

TEST_P(ServerTest, ALateDeviceAnswersLaterByTheGivenTime) {
  Bench bench(GetParam(), {Fault(Kind::kLate, "gyro", 0.25)});
  bench.WaitUntil(1.5);
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
  EXPECT_NEAR(bench.Now_s(), 1.75, 0.01);
}

TEST_P(ServerTest, ADeviceOfAnotherIdentityShowsIt) {
  Bench bench(GetParam(),
              {Fault(Kind::kWrongIdentity, "gyro"), Fault(Kind::kWrongIdentity, "inner.drive")});
  bench.WaitUntil(1.5);
  EXPECT_NE(bench.Read<11>(kGyro, 4, 0).value()[0], 0x4742);
  EXPECT_NE(bench.Read<1>(kDrive, 3, 1).value()[0], 10000);
}

TEST(ServerFaults, AReplyWithAWrongChecksumIsOne) {
  Bench bench(Transport::kRtu, {Fault(Kind::kBadCrc, "gyro")});
  bench.WaitUntil(1.5);
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 0));
  EXPECT_EQ(errno, EMBBADCRC);
}

TEST_P(ServerTest, GarbageIsNeverTakenForAReply) {
  Bench bench(GetParam(), {Fault(Kind::kGarbage, "gyro")});
  bench.WaitUntil(1.5);
  bench.ExpectSilence();
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 0));
}

TEST_P(ServerTest, AFrozenEncoderRepeatsItsLastValue) {
  Bench bench(GetParam(), {Fault(Kind::kFrozen, "inner.encoder")});
  bench.Enable();
  bench.Move(40000);
  bench.WaitUntil(0.9);
  const double before = bench.Angle_deg();
  bench.WaitUntil(1.9);
  EXPECT_EQ(bench.Angle_deg(), before);
  bench.WaitUntil(2.1);
  EXPECT_GT(bench.Angle_deg(), before + 10);
}

TEST_P(ServerTest, ARebootSilencesTheUnitForItsBootTimeAndRaisesTheBootCounter) {
  Bench bench(GetParam(), {Fault(Kind::kReboot, "gyro")});
  const int boots = bench.Read<1>(kGyro, 4, 5).value()[0];
  bench.WaitUntil(1.05);
  bench.ExpectSilence();
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 5));
  bench.WaitUntil(1.2);
  EXPECT_EQ(bench.Read<1>(kGyro, 4, 5).value()[0], boots + 1);
}

TEST_P(ServerTest, AnAlarmShowsInTheStatusAndIsCleared) {
  Bench bench(GetParam(), {Fault(Kind::kAlarm, "inner.drive", 0x0E)});
  bench.Enable();
  bench.WaitUntil(1.5);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0] & 1, 1);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x2203).value()[0], 0x0E);
  ASSERT_TRUE(bench.Write(kDrive, 0x1801, {0x1111}));
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x2203).value()[0], 0);
}

TEST_P(ServerTest, ColdSoakBringsTheSensorToTheTemperatureOfACooledUnit) {
  config::Scenario scenario = config::IdealScenario();
  scenario.thermal.cooled_degC = -15.0;
  Bench bench(GetParam(), {}, scenario);
  bench.WaitUntil(2000);
  bench.stand().ColdSoak();
  bench.WaitUntil(2000.01);
  const auto block = bench.Read<16>(kGyro, 4, 0x4000 + (400000 + 1) % 0x4000).value();
  EXPECT_NEAR(static_cast<std::int16_t>(block[8 + 4]) / 340.0 + 36.53, -15.0, 0.1);
}

TEST(VirtualStandTest, AFreshClientFindsThePseudoTerminalAgain) {
  Bench bench(Transport::kRtu);
  modbus_close(bench.context());
  ASSERT_EQ(modbus_connect(bench.context()), 0);
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
}

TEST(VirtualStandTest, TwoDevicesOfOneUnitAreRefused) {
  const auto clock = MakeVirtualClock(kStart);
  config::StandConfig config = TestStand();
  config.axes[0].encoder.unit = config.axes[0].drive.unit;
  VirtualStand stand(config, config::IdealScenario(), *clock);
  EXPECT_THROW(stand.Serve(config.buses[0]), ConfigError);
}

TEST(VirtualStandTest, APortThatIsTakenIsSaid) {
  const auto clock = MakeVirtualClock(kStart);
  VirtualStand stand(TestStand(), config::IdealScenario(), *clock);
  config::BusConfig bus = TestStand().buses[0];
  bus.transport = Transport::kTcp;
  const config::BusConfig served = stand.Serve(bus);
  try {
    stand.Serve(served, VirtualStand::Port::kAsConfigured);
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find(std::to_string(served.port)), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobench::stand
