// Faults of the scenario, as a client sees them.
#include <gtest/gtest.h>

#include <cerrno>
#include <cstdint>

#include "tests/stand/modbus_bench.h"

namespace gyrobench::stand {
namespace {

using FaultTest = ServerTest;
INSTANTIATE_TEST_SUITE_P(Transports, FaultTest, testing::Values(Transport::kRtu, Transport::kTcp),
                         TransportName);

config::FaultScenario Fault(Kind kind, const char* device, double amount = 0.0) {
  return {.at_s = 1.0, .duration_s = 1.0, .device = device, .kind = kind, .amount = amount};
}

TEST_P(FaultTest, ASilentDeviceAnswersBeforeAndAfterItsFaultAndTheOthersAllTheTime) {
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

TEST_P(FaultTest, ALateDeviceAnswersLaterByTheGivenTime) {
  Bench bench(GetParam(), {Fault(Kind::kLate, "gyro", 0.25)});
  bench.WaitUntil(1.5);
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
  EXPECT_NEAR(bench.Now_s(), 1.75, 0.01);
}

TEST_P(FaultTest, ADeviceOfAnotherIdentityShowsIt) {
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

TEST_P(FaultTest, GarbageIsNeverTakenForAReply) {
  Bench bench(GetParam(), {Fault(Kind::kGarbage, "gyro")});
  bench.WaitUntil(1.5);
  bench.ExpectSilence();
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 0));
}

TEST_P(FaultTest, AFrozenEncoderRepeatsItsLastValue) {
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

TEST_P(FaultTest, ARebootSilencesTheUnitForItsBootTimeAndRaisesTheBootCounter) {
  Bench bench(GetParam(), {Fault(Kind::kReboot, "gyro")});
  const int boots = bench.Read<1>(kGyro, 4, 5).value()[0];
  bench.WaitUntil(1.05);
  bench.ExpectSilence();
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 5));
  bench.WaitUntil(1.2);
  EXPECT_EQ(bench.Read<1>(kGyro, 4, 5).value()[0], boots + 1);
}

TEST_P(FaultTest, AnAlarmShowsInTheStatusAndIsCleared) {
  Bench bench(GetParam(), {Fault(Kind::kAlarm, "inner.drive", 0x0E)});
  bench.Enable();
  bench.WaitUntil(1.5);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0] & 1, 1);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x2203).value()[0], 0x0E);
  ASSERT_TRUE(bench.Write(kDrive, 0x1801, {0x1111}));
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x2203).value()[0], 0);
}

TEST_P(FaultTest, ColdSoakBringsTheSensorToTheTemperatureOfACooledUnit) {
  config::Scenario scenario = config::IdealScenario();
  scenario.thermal.cooled_degC = -15.0;
  Bench bench(GetParam(), {}, scenario);
  bench.WaitUntil(2000);
  bench.stand().ColdSoak();
  bench.WaitUntil(2000.01);
  const auto block = bench.Read<16>(kGyro, 4, 0x4000 + (400000 + 1) % 0x4000).value();
  EXPECT_NEAR(static_cast<std::int16_t>(block[8 + 4]) / 340.0 + 36.53, -15.0, 0.1);
}

}  // namespace
}  // namespace gyrobench::stand
