// What a bus makes of its replies: tries, errors, and what is never used.
#include "drivers/modbus_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>

#include "drivers/modbus_line.h"
#include "tests/drivers/bus_bench.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ModbusBusTest : public testing::TestWithParam<Transport> {};
INSTANTIATE_TEST_SUITE_P(Lines, ModbusBusTest, testing::Values(Transport::kRtu, Transport::kTcp),
                         [](const auto& line) {
                           return line.param == Transport::kRtu ? "Rtu" : "Tcp";
                         });

TEST_P(ModbusBusTest, ReadsAndWritesWhatTheFunctionsName) {
  BusBench bench(GetParam());
  EXPECT_THAT(bench.Read(), kGood);
  std::array<std::uint16_t, 2> input = {};
  bench.bus->ReadInput(kUnit, 0x1004, input, "input");
  EXPECT_THAT(input, ElementsAre(0x5555, 0x6666));
  bench.bus->WriteRegister(kUnit, 0x1003, 0x7777, "one");
  bench.bus->WriteRegisters(kUnit, 0x1004, std::array<std::uint16_t, 2>{0x8888, 0x9999}, "two");
  EXPECT_THAT(bench.Read(), ElementsAre(0x7777, 0x8888, 0x9999));
  EXPECT_EQ(bench.bus->statistics().transactions, 5);
  EXPECT_EQ(bench.bus->statistics().retries, 0);
  EXPECT_EQ(bench.bus->statistics().failures, 0);
  EXPECT_EQ(bench.bus->statistics().connections, 1);
}

TEST_P(ModbusBusTest, OpensNothingBeforeTheFirstTransaction) {
  BusBench bench(GetParam());
  EXPECT_EQ(bench.bus->statistics().connections, 0);
}

TEST_P(ModbusBusTest, SilenceEndsInAnErrorAfterBoundedTriesAndBoundedBenchTime) {
  BusBench bench(GetParam());
  bench.line.Inject(LineFault::kLostRequest, 0, 100);
  const Utime start = bench.clock.Now();
  const std::string failure = bench.ReadFailure();
  EXPECT_THAT(failure, AllOf(HasSubstr("axis.inner drive"), HasSubstr("bus A"), HasSubstr("unit 5"),
                             HasSubstr("status"), HasSubstr("function 03"), HasSubstr("0x1003"),
                             HasSubstr("3 registers"), HasSubstr("no complete reply"),
                             HasSubstr("2 tries"), HasSubstr("Check")));
  EXPECT_EQ(bench.line.requests().size(), 2U);
  EXPECT_GE(bench.clock.Now() - start, 2 * kTimeout_us);
  EXPECT_LE(bench.clock.Now() - start, 4 * kTimeout_us);
  EXPECT_EQ(bench.bus->statistics().failures, 1);
}

// An operator's stop of an axis that turns waits for the tries of a device that is silent.
TEST_P(ModbusBusTest, WhileSomethingUrgentWaitsNothingIsTriedAgain) {
  BusBench bench(GetParam(), 5);
  bool hurries = true;
  config::BusConfig config = bench.line.Config();
  config.retries = 5;
  bench.bus = std::make_unique<ModbusBus>(config, bench.clock, *bench.participant,
                                          [&hurries] { return hurries; });
  bench.line.Inject(LineFault::kLostRequest);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("1 try"));
  hurries = false;
  bench.line.Inject(LineFault::kLostRequest);
  EXPECT_EQ(bench.ReadFailure(), "");
}

struct BadReply {
  LineFault::Kind kind;
  const char* says;
};

// One bad reply is made good by another try; bad replies without end are an error that says what
// came.
TEST_P(ModbusBusTest, BadRepliesAreNeverUsed) {
  const bool rtu = GetParam() == Transport::kRtu;
  const BadReply replies[] = {
      {LineFault::kTruncated, "no complete reply"},
      {LineFault::kBadChecksum, rtu ? "checksum" : "transaction"},
      {LineFault::kWrongFunction, "another function"},
      {LineFault::kWrongLength, "length"},
      {LineFault::kGarbage, "got"},
      {LineFault::kLostReply, "no complete reply"},
  };
  for (const BadReply& reply : replies) {
    BusBench bench(GetParam());
    bench.line.Inject(reply.kind);
    EXPECT_THAT(bench.Read(), kGood) << reply.says;
    EXPECT_EQ(bench.bus->statistics().retries, 1) << reply.says;
    EXPECT_EQ(bench.timing.tries, 2);
    EXPECT_EQ(bench.bus->statistics().connections, rtu ? 1 : 2) << reply.says;
    bench.line.Inject(reply.kind, 0, 2);
    EXPECT_THAT(bench.ReadFailure(), HasSubstr(reply.says));
    EXPECT_THAT(bench.Read(), kGood) << reply.says;
  }
}

TEST(ModbusRtu, AReplyOfAnotherUnitIsNotUsed) {
  BusBench bench(Transport::kRtu);
  bench.line.Inject(LineFault::kWrongUnit, 0, 2);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("another unit"));
  EXPECT_THAT(bench.Read(), kGood);
}

// In virtual time a reply can be late although it came: bench time has passed, real time has not.
TEST_P(ModbusBusTest, ALateReplyIsNotUsed) {
  BusBench bench(GetParam());
  bench.line.Inject(LineFault::kLate, 2 * kTimeout_us, 2);
  EXPECT_THAT(bench.ReadFailure(), AllOf(HasSubstr("200.0 ms"), HasSubstr("too late")));
  EXPECT_THAT(bench.Read(), kGood);
}

TEST_P(ModbusBusTest, AnExceptionIsARefusalAtOnceAndNamesItself) {
  BusBench bench(GetParam(), 3);
  bench.line.Inject(LineFault::kException, 2);
  EXPECT_THAT(bench.ReadFailure(), AllOf(HasSubstr("exception 02 (illegal data address)"),
                                         HasSubstr("(1 try)"), HasSubstr("register map")));
  EXPECT_EQ(bench.line.requests().size(), 1U);
  std::array<std::uint16_t, 1> value = {};
  EXPECT_THROW(bench.bus->ReadHolding(kUnit, 0x7000, value, "nothing"), RefusedByDevice);
  EXPECT_EQ(bench.bus->statistics().connections, 1);
}

TEST_P(ModbusBusTest, AnErrorHasItsDeviceActionCodeAndAddressAsFields) {
  using CodeKind = DeviceFailure::CodeKind;
  struct Case {
    LineFault::Kind fault;
    int detail;
    CodeKind kind;
    int code;
  };
  for (const Case& c : {Case{LineFault::kException, 2, CodeKind::kModbusException, 2},
                        Case{LineFault::kLostReply, 0, CodeKind::kSystemError, ETIMEDOUT}}) {
    BusBench bench(GetParam(), 0);
    bench.line.Inject(c.fault, c.detail);
    try {
      bench.Read();
      FAIL() << "no error";
    } catch (const DeviceError& error) {
      EXPECT_EQ(error.failure().device, kUnit.name);
      EXPECT_EQ(error.failure().action, "status");
      EXPECT_EQ(error.failure().address, 0x1003);
      EXPECT_EQ(error.failure().code_kind, c.kind);
      EXPECT_EQ(error.failure().code, c.code);
    }
  }
}

TEST(ModbusRtu, ABadFrameIsToldApartFromSilence) {
  BusBench bench(Transport::kRtu, 0);
  bench.line.Inject(LineFault::kWrongUnit);
  try {
    bench.Read();
    FAIL() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.failure().code_kind, DeviceFailure::CodeKind::kBadReply);
  }
}

TEST_P(ModbusBusTest, ABusyDeviceIsAskedAgain) {
  BusBench bench(GetParam());
  bench.line.Inject(LineFault::kException, 6);
  EXPECT_THAT(bench.Read(), kGood);
  bench.line.Inject(LineFault::kException, 6, 2);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("device busy"));
}

TEST_P(ModbusBusTest, AFrameLeftOverIsNotTheNextAnswer) {
  BusBench bench(GetParam());
  for (int i = 0; i < 20; ++i) {
    bench.line.Inject(LineFault::kExtraAfter);
    EXPECT_THAT(bench.Read(), kGood);
    EXPECT_THAT(bench.Read(), kGood);
  }
}

// On RTU a frame does not say which request it answers. The line is watched for as long again as
// the reply had, and what comes then is thrown away.
TEST(ModbusRtu, AReplyThatComesAfterItsDeadlineIsNotTheNextAnswer) {
  BusBench bench(Transport::kRtu, 0);
  bench.line.Inject(LineFault::kHeld);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("no complete reply"));
  bench.unit.SetHolding(0x1003, {0x7777, 0x8888, 0x9999});
  bench.clock.on_wait = [&] { bench.line.ReleaseHeld(); };
  EXPECT_THAT(bench.Read(), ElementsAre(0x7777, 0x8888, 0x9999));
}

TEST(ModbusTcp, AReplyToAnEarlierRequestIsNotUsed) {
  BusBench bench(Transport::kTcp);
  EXPECT_THAT(bench.Read(), kGood);
  bench.unit.SetHolding(0x1003, {0x7777, 0x8888, 0x9999});
  bench.line.Inject(LineFault::kRepeatOld);
  EXPECT_THAT(bench.Read(), ElementsAre(0x7777, 0x8888, 0x9999));
  EXPECT_EQ(bench.bus->statistics().connections, 2);
}

// libmodbus would ask the unit of the request before instead.
TEST_P(ModbusBusTest, AUnitNumberThatCannotBeIsRefused) {
  BusBench bench(GetParam());
  EXPECT_THAT(bench.Read(), kGood);
  std::array<std::uint16_t, 1> value = {};
  for (const int unit : {-1, 248, 300}) {
    EXPECT_THROW(bench.bus->ReadHolding({"drive", unit}, 0x1003, value, "status"), ConfigError);
  }
}

TEST_P(ModbusBusTest, ARequestThatMustNotBeRepeatedIsSentOnce) {
  BusBench bench(GetParam(), 5);
  bench.line.Inject(LineFault::kLostReply);
  const std::array<std::uint16_t, 1> value = {1};
  EXPECT_THROW(bench.bus->WriteRegisters(kUnit, 0x6200, value, "move", Repeat::kNever),
               DeviceError);
  EXPECT_EQ(bench.line.requests().size(), 1U);
}

TEST_P(ModbusBusTest, AVerifiedWriteNoticesARegisterThatDoesNotTakeIt) {
  BusBench bench(GetParam());
  EXPECT_NO_THROW(bench.bus->WriteVerified(kUnit, 0x1003, 7, "enable"));
  bench.unit.OnWrite([](std::uint16_t, const Words&, RegisterUnit::Registers& holding) {
    holding[0x1003] = 0x0BAD;
  });
  try {
    bench.bus->WriteVerified(kUnit, 0x1003, 7, "enable");
    FAIL() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("enable"), HasSubstr("0x1003"), HasSubstr("0x0007"),
                                    HasSubstr("0x0BAD")));
  }
}

// Whoever wakes the bus's thread (a stop) must not be overheard because a device was silent.
TEST_P(ModbusBusTest, ANotifyDuringAFailingTransactionIsKept) {
  BusBench bench(GetParam(), 0);
  bench.line.Inject(LineFault::kLostRequest);
  bench.participant->Notify();
  const Utime start = bench.clock.Now();
  EXPECT_NE(bench.ReadFailure(), "");
  EXPECT_GE(bench.clock.Now() - start, kTimeout_us);
  EXPECT_TRUE(bench.participant->WaitUntil(bench.clock.Now() + 1));
}

TEST(ModbusVirtualTime, SilenceCostsBenchTimeAsConfiguredAndALateReplyIsTimedOut) {
  const auto clock = MakeVirtualClock(1'000'000);
  const auto participant = clock->Join("bus", Clock::Role::kResident);
  const auto guest = clock->Join("line", Clock::Role::kGuest);
  RegisterUnit unit;
  unit.SetHolding(0, {42});
  FakeLine line(Transport::kTcp);
  line.Connect(kUnit.unit, unit);
  line.SetDelay([&](Utime duration_us) { guest->WaitUntil(clock->Now() + duration_us); });
  config::BusConfig config = line.Config();
  config.retries = 0;
  ModbusBus bus(config, *clock, *participant);
  std::array<std::uint16_t, 1> value = {};

  line.Inject(LineFault::kLate, 40'000);
  const Timing timing = bus.ReadHolding(kUnit, 0, value, "value");
  EXPECT_EQ(timing.utime_reply - timing.utime_request, 40'000);
  EXPECT_EQ(timing.utime_latched - timing.utime_request, 20'000);

  line.Inject(LineFault::kLate, 500'000);
  EXPECT_THROW(bus.ReadHolding(kUnit, 0, value, "value"), DeviceError);

  const Utime start = clock->Now();
  line.Inject(LineFault::kLostRequest);
  EXPECT_THROW(bus.ReadHolding(kUnit, 0, value, "value"), DeviceError);
  EXPECT_EQ(clock->Now() - start, kTimeout_us);
}

}  // namespace
}  // namespace gyrobench::drivers
