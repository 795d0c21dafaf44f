#include "drivers/modbus_bus.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>

#include "drivers/modbus_line.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using Transport = config::BusConfig::Transport;

constexpr Utime kTimeout_us = 100'000;
const ModbusUnit kUnit = {"axis.inner drive", 5};

// A line of one transport with a unit 5 whose registers all differ, and a bus with one retry.
class Bench {
 public:
  explicit Bench(Transport transport, int retries = 1) : line(transport) {
    unit.SetHolding(0x1003, {0x1111, 0x2222, 0x3333});
    unit.SetInput(0x1003, {0x4444, 0x5555, 0x6666});
    line.Connect(kUnit.unit, unit);
    line.SetDelay([this](Utime duration_us) { clock.Advance(duration_us); });
    config::BusConfig config = line.Config();
    config.retries = retries;
    bus = std::make_unique<ModbusBus>(config, clock, *participant);
  }

  std::array<std::uint16_t, 3> Read() {
    std::array<std::uint16_t, 3> values = {};
    timing = bus->ReadHolding(kUnit, 0x1003, values, "status");
    return values;
  }
  // What the DeviceError of the next read says; empty when there is none.
  std::string ReadFailure() {
    try {
      Read();
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  }

  ManualClock clock;
  std::unique_ptr<Clock::Participant> participant = clock.Join("bus A", Clock::Role::kResident);
  RegisterUnit unit;
  FakeLine line;
  std::unique_ptr<ModbusBus> bus;
  Timing timing;
};

const auto kGood = ElementsAre(0x1111, 0x2222, 0x3333);

class ModbusBusTest : public testing::TestWithParam<Transport> {};
INSTANTIATE_TEST_SUITE_P(Lines, ModbusBusTest, testing::Values(Transport::kRtu, Transport::kTcp),
                         [](const auto& line) {
                           return line.param == Transport::kRtu ? "Rtu" : "Tcp";
                         });

TEST_P(ModbusBusTest, ReadsAndWritesWhatTheFunctionsName) {
  Bench bench(GetParam());
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
  Bench bench(GetParam());
  EXPECT_EQ(bench.bus->statistics().connections, 0);
}

TEST_P(ModbusBusTest, SilenceEndsInAnErrorAfterBoundedTriesAndBoundedBenchTime) {
  Bench bench(GetParam());
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
  Bench bench(GetParam(), 5);
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
    Bench bench(GetParam());
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
  Bench bench(Transport::kRtu);
  bench.line.Inject(LineFault::kWrongUnit, 0, 2);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("another unit"));
  EXPECT_THAT(bench.Read(), kGood);
}

// In virtual time a reply can be late although it came: bench time has passed, real time has not.
TEST_P(ModbusBusTest, ALateReplyIsNotUsed) {
  Bench bench(GetParam());
  bench.line.Inject(LineFault::kLate, 2 * kTimeout_us, 2);
  EXPECT_THAT(bench.ReadFailure(), AllOf(HasSubstr("200.0 ms"), HasSubstr("too late")));
  EXPECT_THAT(bench.Read(), kGood);
}

TEST_P(ModbusBusTest, AnExceptionIsARefusalAtOnceAndNamesItself) {
  Bench bench(GetParam(), 3);
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
    Bench bench(GetParam(), 0);
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
  Bench bench(Transport::kRtu, 0);
  bench.line.Inject(LineFault::kWrongUnit);
  try {
    bench.Read();
    FAIL() << "no error";
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.failure().code_kind, DeviceFailure::CodeKind::kBadReply);
  }
}

TEST_P(ModbusBusTest, ABusyDeviceIsAskedAgain) {
  Bench bench(GetParam());
  bench.line.Inject(LineFault::kException, 6);
  EXPECT_THAT(bench.Read(), kGood);
  bench.line.Inject(LineFault::kException, 6, 2);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("device busy"));
}

TEST_P(ModbusBusTest, AFrameLeftOverIsNotTheNextAnswer) {
  Bench bench(GetParam());
  for (int i = 0; i < 20; ++i) {
    bench.line.Inject(LineFault::kExtraAfter);
    EXPECT_THAT(bench.Read(), kGood);
    EXPECT_THAT(bench.Read(), kGood);
  }
}

// On RTU a frame does not say which request it answers. The line is watched for as long again as
// the reply had, and what comes then is thrown away.
TEST(ModbusRtu, AReplyThatComesAfterItsDeadlineIsNotTheNextAnswer) {
  Bench bench(Transport::kRtu, 0);
  bench.line.Inject(LineFault::kHeld);
  EXPECT_THAT(bench.ReadFailure(), HasSubstr("no complete reply"));
  bench.unit.SetHolding(0x1003, {0x7777, 0x8888, 0x9999});
  bench.clock.on_wait = [&] { bench.line.ReleaseHeld(); };
  EXPECT_THAT(bench.Read(), ElementsAre(0x7777, 0x8888, 0x9999));
}

TEST(ModbusTcp, AReplyToAnEarlierRequestIsNotUsed) {
  Bench bench(Transport::kTcp);
  EXPECT_THAT(bench.Read(), kGood);
  bench.unit.SetHolding(0x1003, {0x7777, 0x8888, 0x9999});
  bench.line.Inject(LineFault::kRepeatOld);
  EXPECT_THAT(bench.Read(), ElementsAre(0x7777, 0x8888, 0x9999));
  EXPECT_EQ(bench.bus->statistics().connections, 2);
}

TEST(ModbusTcp, ADroppedConnectionIsMadeAnew) {
  Bench bench(Transport::kTcp);
  EXPECT_THAT(bench.Read(), kGood);
  bench.line.Inject(LineFault::kDisconnect);
  EXPECT_THAT(bench.Read(), kGood);
  EXPECT_EQ(bench.bus->statistics().connections, 2);
}

TEST(ModbusTcp, AServerThatWentAwayEndsInAnErrorThatNamesItsAddress) {
  Bench bench(Transport::kTcp);
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
  Bench bench(Transport::kTcp, 5);
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
  Bench bench(Transport::kRtu);
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
  Bench bench(Transport::kRtu);
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

// libmodbus would ask the unit of the request before instead.
TEST_P(ModbusBusTest, AUnitNumberThatCannotBeIsRefused) {
  Bench bench(GetParam());
  EXPECT_THAT(bench.Read(), kGood);
  std::array<std::uint16_t, 1> value = {};
  for (const int unit : {-1, 248, 300}) {
    EXPECT_THROW(bench.bus->ReadHolding({"drive", unit}, 0x1003, value, "status"), ConfigError);
  }
}

TEST_P(ModbusBusTest, ARequestThatMustNotBeRepeatedIsSentOnce) {
  Bench bench(GetParam(), 5);
  bench.line.Inject(LineFault::kLostReply);
  const std::array<std::uint16_t, 1> value = {1};
  EXPECT_THROW(bench.bus->WriteRegisters(kUnit, 0x6200, value, "move", Repeat::kNever),
               DeviceError);
  EXPECT_EQ(bench.line.requests().size(), 1U);
}

TEST_P(ModbusBusTest, AVerifiedWriteNoticesARegisterThatDoesNotTakeIt) {
  Bench bench(GetParam());
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
  Bench bench(GetParam(), 0);
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

// hardware.md: the vendor's own example of this frame ends in DD 7B, which is wrong.
TEST(ModbusRtu, FramesEndInTheChecksumOfTheStandard) {
  Bench bench(Transport::kRtu);
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
  Bench bench(Transport::kRtu);
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
