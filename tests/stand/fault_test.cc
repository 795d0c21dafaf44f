// Faults of the scenario, as a client sees them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <vector>

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

TEST_P(FaultTest, ADeviceThatRefusesGivesTheException) {
  Bench bench(GetParam(), {Fault(Kind::kException, "gyro", 6)});
  bench.WaitUntil(1.5);
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 0));
  EXPECT_EQ(errno, EMBXSBUSY);
  bench.WaitUntil(2.5);
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
}

TEST(ServerFaults, AStaleReplyIsTheOneToTheRequestBefore) {
  Bench bench(Transport::kRtu, {Fault(Kind::kStale, "inner.drive")});
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x0001).value()[0], 10000);  // pulses per turn
  bench.WaitUntil(1.5);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x000F).value()[0], 10000);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x0001).value()[0], 0);
  bench.WaitUntil(2.5);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x0001).value()[0], 10000);
}

TEST_P(FaultTest, AFaultOfTheLineHitsTheShareOfRequestsThatTheScenarioSaysAndTheSameOnesAgain) {
  auto fault = Fault(Kind::kException, "gyro");
  fault.duration_s = 100;
  fault.probability = 0.3;
  std::vector<bool> first;
  for (int run = 0; run < 2; ++run) {
    Bench bench(GetParam(), {fault});
    bench.WaitUntil(1.5);
    std::vector<bool> hit;
    for (int i = 0; i < 200; ++i) hit.push_back(!bench.Read<1>(kGyro, 4, 0));
    EXPECT_NEAR(static_cast<double>(std::ranges::count(hit, true)), 60, 20);
    if (run == 0) first = hit;
    EXPECT_EQ(hit, first);
  }
}

TEST_P(FaultTest, AFaultWaitsForTheMoveAndForTheRequestThatItBeginsWith) {
  auto by_move = Fault(Kind::kException, "inner.encoder");
  by_move.on = config::FaultScenario::On::kMove;
  by_move.count = 2;
  auto by_request = Fault(Kind::kException, "gyro");
  by_request.at_s = 0.0;
  by_request.on = config::FaultScenario::On::kRequest;
  by_request.count = 3;
  Bench bench(GetParam(), {by_move, by_request});
  bench.Enable();
  bench.Move(100);
  bench.WaitUntil(2.0);
  EXPECT_TRUE(bench.Read<2>(kEncoder, 3, 0));
  bench.Move(100);
  EXPECT_TRUE(bench.Read<2>(kEncoder, 3, 0));
  bench.WaitUntil(3.5);  // at_s = 1 after the move
  EXPECT_FALSE(bench.Read<2>(kEncoder, 3, 0));
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
  EXPECT_TRUE(bench.Read<1>(kGyro, 4, 0));
  EXPECT_FALSE(bench.Read<1>(kGyro, 4, 0));
}

TEST_P(FaultTest, AnEncoderThatJumpsOrDropsOutGivesAnotherValueAndComesBack) {
  auto dropout = Fault(Kind::kDropout, "inner.encoder", 0x12345);
  dropout.at_s = 3.0;
  Bench bench(GetParam(), {Fault(Kind::kJump, "inner.encoder", 7.0), dropout});
  EXPECT_NEAR(bench.Angle_deg(), 0.0, 0.01);
  bench.WaitUntil(1.5);
  EXPECT_NEAR(bench.Angle_deg(), 7.0, 0.01);
  bench.WaitUntil(2.5);
  EXPECT_NEAR(bench.Angle_deg(), 0.0, 0.01);
  bench.WaitUntil(3.5);
  EXPECT_EQ(bench.Read<2>(kEncoder, 3, 0).value()[1], 0x2345);
}

// At once, when a positive move begins; on the way back it follows.
TEST_P(FaultTest, ALooseEncoderStaysBehindByAShareOfEachPositiveMove) {
  Bench bench(GetParam(), {Fault(Kind::kLoose, "inner.encoder", 0.25)});
  bench.Enable();
  bench.WaitUntil(1.5);
  bench.Move(10000);  // a turn of the shaft, 9 deg of the table
  bench.WaitUntil(6.0);
  EXPECT_NEAR(bench.Angle_deg(), 0.75 * 9.0, 0.05);
  bench.Move(-10000);
  bench.WaitUntil(11.0);
  EXPECT_NEAR(bench.Angle_deg(), -0.25 * 9.0, 0.05);
}

TEST_P(FaultTest, ADriveThatLostPowerIsDisabledAtRestAndCountsFromZero) {
  Bench bench(GetParam(), {Fault(Kind::kReboot, "inner.drive")});
  bench.Enable();
  bench.Move(400000);
  bench.WaitUntil(2.0);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x000F).value()[0], 0);
  EXPECT_LT(bench.Position(), 1000);
  const double angle = bench.Angle_deg();
  EXPECT_GT(angle, 10);
  bench.WaitUntil(3.0);
  EXPECT_EQ(bench.Angle_deg(), angle);
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

TEST_P(FaultTest, AnEmergencyStopEndsTheMotionAndTheDriveIsDisabledUntilItIsReleased) {
  Bench bench(GetParam(), {Fault(Kind::kEmergencyStop, "inner.drive")});
  bench.Enable();
  ASSERT_TRUE(bench.Move(100'000, 300));
  bench.WaitUntil(1.9);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, kInputs).value()[0], 1);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0] & 0x6, 0);  // neither enabled nor moving
  const std::int32_t stopped = bench.Position();
  EXPECT_LT(stopped, 99'000);
  EXPECT_TRUE(bench.Enable());
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0] & 0x2, 0);
  bench.WaitUntil(2.5);
  EXPECT_EQ(bench.Read<1>(kDrive, 3, kInputs).value()[0], 0);
  EXPECT_EQ(bench.Position(), stopped);
  bench.Enable();
  EXPECT_EQ(bench.Read<1>(kDrive, 3, 0x1003).value()[0] & 0x2, 0x2);
}

TEST_P(FaultTest, ALimitEndsTheMotionAndHoldsTheWayOnAndNotTheWayBack) {
  for (const int sign : {1, -1}) {
    Bench bench(GetParam(),
                {Fault(sign > 0 ? Kind::kLimitPlus : Kind::kLimitMinus, "inner.drive")});
    bench.Enable();
    ASSERT_TRUE(bench.Move(sign * 100'000, 300));
    bench.WaitUntil(1.5);
    EXPECT_EQ(bench.Read<1>(kDrive, 3, kInputs).value()[0], sign > 0 ? 2 : 4);
    const std::int32_t stopped = bench.Position();
    EXPECT_LT(sign * stopped, 99'000);
    ASSERT_TRUE(bench.Move(sign * 1000));
    bench.WaitUntil(1.7);
    EXPECT_EQ(bench.Position(), stopped);
    ASSERT_TRUE(bench.Move(-sign * 100));
    bench.WaitUntil(1.95);
    EXPECT_EQ(bench.Position(), stopped - sign * 100);
  }
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
