// The stand behind Modbus, asked by libmodbus as the drivers do.
#include <gtest/gtest.h>
#include <modbus/modbus.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>

#include "base/error.h"
#include "tests/stand/modbus_bench.h"

namespace gyrobench::stand {
namespace {

INSTANTIATE_TEST_SUITE_P(Transports, ServerTest, testing::Values(Transport::kRtu, Transport::kTcp),
                         TransportName);

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

// As of a drive, twice the pulses a turn are half the way, and the count goes on in pulses of now.
TEST_P(ServerTest, PulsesPerTurnAreSetWhileItStandsAndTurnTheTableByAsMuch) {
  Bench bench(GetParam());
  ASSERT_TRUE(bench.Write(kDrive, 0x0001, {20000}));
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x0001).value()[0], 20000);
  bench.Enable();
  ASSERT_TRUE(bench.Move(20000));
  bench.WaitUntil(0.5);
  EXPECT_FALSE(bench.Write(kDrive, 0x0001, {10000}));
  bench.WaitUntil(5.0);
  EXPECT_EQ(bench.Position(), 20000);
  EXPECT_NEAR(bench.Angle_deg(), 9.0, 1e-3);
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
