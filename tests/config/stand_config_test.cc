#include "config/stand_config.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "config/bus_load.h"
#include "tests/config/config_files.h"

namespace gyrobench::config {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

class StandFile : public testing::Test {
 protected:
  StandFile() { folder_.CopyConfig(); }

  std::string Shipped() const { return ReadText(ConfigFolder() / "stand.toml"); }
  StandConfig Load(const std::string& text) const {
    return LoadStandConfig(folder_.Write("edited.toml", text));
  }
  // The error of stand.toml with one edit; must name the edited line.
  std::string ErrorAfter(const std::string& section, const std::string& from,
                         const std::string& to) const {
    const std::string text = Replace(Shipped(), section, from, to);
    std::string error = ErrorOf([&] { Load(text); });
    EXPECT_THAT(error, HasSubstr(fmt::format("edited.toml:{}: ", LineOf(text, section, to))));
    return error;
  }
  TestFolder folder_;
};

// The daemon's record was named by a path that the client, in another folder, did not find.
TEST_F(StandFile, NamesTheRecordsByAPathThatHoldsInEveryFolder) {
  folder_.Write("stand.toml",
                "include = \"" + ConfigFolder().string() + "/virtual.toml\"\nrecords = \"r\"\n");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  const StandConfig stand = LoadStandConfig("stand.toml");
  std::filesystem::current_path(before);
  EXPECT_EQ(stand.records, std::filesystem::canonical(folder_.path()) / "r");
}

// Every field has a value of its own, so that two that were swapped would show.
TEST_F(StandFile, FillsEveryFieldFromItsKey) {
  folder_.Write("sub/scenario.toml", "");
  const StandConfig stand = Load(R"(name = "n"
records = "r"
procedures = ["p", "/q"]
control_socket = "c.sock"
control_socket_mode = 0o600
[bus.one]
transport = "rtu"
device = "/dev/ttyS7"
baud = 921600
parity = "E"
stop_bits = 2
response_timeout_s = 0.25
retries = 5
[bus.two]
transport = "tcp"
host = "h"
port = 1502
response_timeout_s = 0.5
retries = 6
[axis.middle]
gear_ratio = 41
shaft_accuracy_deg = 1.5
min_deg = -100
max_deg = 200
max_rate_deg_s = 30
max_acceleration_deg_s2 = 50
following_error_deg = 0.75
[axis.middle.drive]
bus = "one"
unit = 8
map = "devices/leadshine-rs.toml"
pulses_per_turn = 3200
sign = -1
[axis.middle.encoder]
bus = "two"
unit = 9
map = "devices/qy3806-encoder.toml"
counts_per_turn = 4096
range_counts = 65536
word_order = "low_first"
sign = -1
offset_deg = 12.5
rate_hz = 60
idle_rate_hz = 6
[gyro]
bus = "two"
unit = 22
map = "devices/gyro-unit.toml"
range_deg_s = 500
filter = 4
rate_hz = 250
accel_range_g = 8
serial_number = 4294967295
[geometry]
mount_x_deg = 1
mount_y_deg = 2
mount_z_deg = 3
[site]
latitude_deg = -33
heading_deg = 77
[reference]
scale_uncertainty = 0.0002
eccentricity_deg = 0.01
alignment_deg = 0.4
[lcm]
url = "udpm://239.1.2.3:7777?ttl=1"
channel_prefix = "LAB_2"
required = true
[safety]
silence_s = 2.5
[virtual]
scenario = "sub/scenario.toml"
seed = 9007199254740993
pace = 3
idle_pace = 4
truth = "t.csv"
[virtual.answers]
cool = "done"
place = "skip"
)");
  EXPECT_EQ(stand.file, folder_.path() / "edited.toml");
  EXPECT_EQ(stand.name, "n");
  EXPECT_EQ(stand.records, folder_.path() / "r");
  EXPECT_THAT(stand.procedure_dirs, ElementsAre(folder_.path() / "p", "/q"));
  EXPECT_EQ(stand.control_socket, folder_.path() / "c.sock");
  EXPECT_EQ(stand.control_socket_mode, 0600u);

  ASSERT_EQ(stand.buses.size(), 2u);
  const BusConfig& one = stand.buses[0];
  EXPECT_EQ(one.name, "one");
  EXPECT_EQ(one.transport, BusConfig::Transport::kRtu);
  EXPECT_EQ(one.device, "/dev/ttyS7");
  EXPECT_EQ(one.baud, 921600);
  EXPECT_EQ(one.parity, 'E');
  EXPECT_EQ(one.stop_bits, 2);
  EXPECT_EQ(one.response_timeout_s, 0.25);
  EXPECT_EQ(one.retries, 5);
  const BusConfig& two = stand.buses[1];
  EXPECT_EQ(two.name, "two");
  EXPECT_EQ(two.transport, BusConfig::Transport::kTcp);
  EXPECT_EQ(two.host, "h");
  EXPECT_EQ(two.port, 1502);
  EXPECT_EQ(two.response_timeout_s, 0.5);
  EXPECT_EQ(two.retries, 6);

  ASSERT_EQ(stand.axes.size(), 1u);
  const AxisConfig& axis = stand.axes[0];
  EXPECT_EQ(axis.name, "middle");
  EXPECT_EQ(axis.gear_ratio, 41);
  EXPECT_EQ(axis.shaft_accuracy_deg, 1.5);
  EXPECT_EQ(axis.min_deg, -100);
  EXPECT_EQ(axis.max_deg, 200);
  EXPECT_EQ(axis.max_rate_deg_s, 30);
  EXPECT_EQ(axis.max_acceleration_deg_s2, 50);
  EXPECT_EQ(axis.following_error_deg, 0.75);
  EXPECT_EQ(axis.drive.bus, "one");
  EXPECT_EQ(axis.drive.unit, 8);
  EXPECT_EQ(axis.drive.map.model, "Leadshine RS");
  EXPECT_EQ(axis.drive.map.pulses_per_turn, 3200);
  EXPECT_EQ(axis.drive.sign, -1);
  EXPECT_EQ(axis.encoder.bus, "two");
  EXPECT_EQ(axis.encoder.unit, 9);
  EXPECT_EQ(axis.encoder.map.model, "QY3806-485RTU");
  EXPECT_EQ(axis.encoder.map.counts_per_turn, 4096);
  EXPECT_EQ(axis.encoder.map.range_counts, 65536u);
  EXPECT_EQ(axis.encoder.map.word_order, WordOrder::kLowFirst);
  EXPECT_EQ(axis.encoder.sign, -1);
  EXPECT_EQ(axis.encoder.offset_deg, 12.5);
  EXPECT_EQ(axis.encoder.rate_hz, 60);
  EXPECT_EQ(axis.encoder.idle_rate_hz, 6);

  EXPECT_EQ(stand.gyro.bus, "two");
  EXPECT_EQ(stand.gyro.unit, 22);
  EXPECT_EQ(stand.gyro.map.magic, 0x4742);
  EXPECT_EQ(stand.gyro.range_deg_s, 500);
  EXPECT_EQ(stand.gyro.filter, 4);
  EXPECT_EQ(stand.gyro.rate_hz, 250);
  EXPECT_EQ(stand.gyro.accel_range_g, 8);
  EXPECT_EQ(stand.gyro.serial_number, 4294967295u);
  EXPECT_EQ(stand.geometry.mount_deg[0], 1);
  EXPECT_EQ(stand.geometry.mount_deg[1], 2);
  EXPECT_EQ(stand.geometry.mount_deg[2], 3);
  EXPECT_EQ(stand.site.latitude_deg, -33);
  EXPECT_EQ(stand.reference.scale_uncertainty, 0.0002);
  EXPECT_EQ(stand.reference.eccentricity_deg, 0.01);
  EXPECT_EQ(stand.reference.alignment_deg, 0.4);
  EXPECT_EQ(stand.site.heading_deg, 77);
  EXPECT_EQ(stand.lcm.url, "udpm://239.1.2.3:7777?ttl=1");
  EXPECT_EQ(stand.lcm.channel_prefix, "LAB_2");
  EXPECT_TRUE(stand.lcm.required);
  EXPECT_EQ(stand.safety.silence_s, 2.5);

  ASSERT_TRUE(stand.virtual_stand);
  EXPECT_EQ(stand.virtual_stand->scenario, folder_.path() / "sub/scenario.toml");
  EXPECT_EQ(stand.virtual_stand->seed, 9007199254740993u);  // not representable in a double
  EXPECT_EQ(stand.virtual_stand->pace, 3);
  EXPECT_EQ(stand.virtual_stand->idle_pace, 4);
  EXPECT_EQ(stand.virtual_stand->truth, folder_.path() / "t.csv");
  EXPECT_THAT(stand.virtual_stand->answers,
              ElementsAre(Pair("cool", "done"), Pair("place", "skip")));
}

TEST_F(StandFile, NamesFileLineKeyValueAndRange) {
  EXPECT_THAT(
      ErrorAfter("[axis.inner]", "max_rate_deg_s = 60", "max_rate_deg_s = -5"),
      HasSubstr("axis.inner.max_rate_deg_s = -5: expected a number in 0.001 .. 1000 deg/s"));
}

TEST_F(StandFile, SuggestsTheNearestKnownKey) {
  EXPECT_THAT(ErrorAfter("[axis.inner.encoder]", "offset_deg", "ofset_deg"),
              HasSubstr("unknown key axis.inner.encoder.ofset_deg; did you mean \"offset_deg\"?"));
  EXPECT_THAT(ErrorOf([&] { Load(Shipped() + "\n[axis.middel]\n"); }),
              HasSubstr("unknown key axis.middel; did you mean \"middle\"?"));
  EXPECT_THAT(ErrorAfter("[lcm]", "url = ", "host = "), HasSubstr("unknown key lcm.host"));
}

TEST_F(StandFile, RefusesADeviceOnABusThatIsNotThere) {
  EXPECT_THAT(ErrorAfter("[gyro]", "bus = \"b\"", "bus = \"c\""),
              HasSubstr("gyro.bus = \"c\": no such bus: expected one of \"a\", \"b\""));
}

TEST_F(StandFile, RefusesTwoDevicesThatWouldAnswerAtOnce) {
  EXPECT_THAT(ErrorAfter("[axis.inner.encoder]", "unit = 13", "unit = 1"),
              HasSubstr("axis.outer.drive is unit 1 on bus \"a\" already"));
  const auto text = Replace(Shipped(), "[gyro]", "unit = 21", "unit = 3");
  EXPECT_NO_THROW(Load(text)) << "equal units on different buses are well";
}

TEST_F(StandFile, RefusesSoftLimitsUpsideDown) {
  EXPECT_THAT(ErrorAfter("[axis.outer]", "min_deg = -3600", "min_deg = 3600"),
              HasSubstr("axis.outer.min_deg = 3600: expected less than max_deg = 3600 deg"));
}

TEST_F(StandFile, RefusesARateThatTheDriveCannotTurn) {
  // 3000 rpm / 40 * 6 deg/s per rpm.
  EXPECT_THAT(ErrorAfter("[axis.outer]", "max_rate_deg_s = 60", "max_rate_deg_s = 451"),
              AllOf(HasSubstr("expected 0.15 .. 450 deg/s"), HasSubstr("1 .. 3000 rpm")));
  EXPECT_THAT(ErrorAfter("[axis.outer]", "max_rate_deg_s = 60", "max_rate_deg_s = 0.14"),
              HasSubstr("expected 0.15 .. 450 deg/s"));
  EXPECT_NO_THROW(
      Load(Replace(Shipped(), "[axis.outer]", "max_rate_deg_s = 60", "max_rate_deg_s = 450")));
}

TEST_F(StandFile, RefusesAnAccelerationBelowTheDrivesLongestRamp) {
  // 1000 rpm in 32.767 s: 150 deg/s of the table in 32.767 s.
  EXPECT_THAT(ErrorAfter("[axis.outer]", "deg_s2 = 200", "deg_s2 = 4.5"),
              HasSubstr("expected at least 4.578 deg/s^2"));
}

TEST_F(StandFile, RefusesABaudRateThatLibmodbusWouldTurnInto9600) {
  for (const char* baud : {"14400", "128000", "250000", "2000000"}) {
    EXPECT_THAT(ErrorAfter("[bus.a]", "baud = 115200", std::string("baud = ") + baud),
                HasSubstr("libmodbus would silently set 9600"));
  }
}

TEST_F(StandFile, RefusesALineThatCannotCarryWhatIsPolledAndSaysHowFull) {
  EXPECT_THAT(ErrorAfter("[bus.a]", "baud = 115200", "baud = 9600"),
              AllOf(HasSubstr("bus.a.baud = 9600"), HasSubstr("axis.inner.encoder 125 %"),
                    HasSubstr("expected at most 90 %")));
  const auto fast = Replace(Shipped(), "[gyro]", "rate_hz = 200", "rate_hz = 1000");
  EXPECT_THAT(ErrorOf([&] { Load(fast); }), HasSubstr("bus.b.baud = 115200"));
  EXPECT_NO_THROW(Load(Replace(fast, "[bus.b]", "baud = 115200", "baud = 500000")));
}

// An independent count of the bytes: a read of one sample block is 8 bytes out and 5 + 2 * 120
// back, each followed by 3.5 characters of silence, at 10 bits a character.
TEST_F(StandFile, KnowsTheShareOfALineThatTheGyroTakes) {
  const StandConfig stand = Load(Shipped());
  const auto loads = BusLoad(stand, stand.buses[1]);
  ASSERT_EQ(loads.size(), 1u);
  EXPECT_NEAR(loads[0].share, 200.0 / 13 * (8 + 245 + 7) * 10 / 115200, 1e-12);
  StandConfig parity = stand;
  parity.buses[1].parity = 'E';
  EXPECT_NEAR(BusLoad(parity, parity.buses[1])[0].share, 1.1 * loads[0].share, 1e-12);
}

TEST_F(StandFile, RefusesASampleRateThatTheSensorCannotDivide) {
  EXPECT_THAT(ErrorAfter("[gyro]", "rate_hz = 200", "rate_hz = 300"),
              AllOf(HasSubstr("1000 / (1 + d) Hz"), HasSubstr("333.333"), HasSubstr("250.000")));
  EXPECT_NO_THROW(Load(Replace(Shipped(), "[gyro]", "rate_hz = 200", "rate_hz = 333.333")));
}

TEST_F(StandFile, RefusesARangeThatTheSensorHasNot) {
  EXPECT_THAT(ErrorAfter("[gyro]", "range_deg_s = 250", "range_deg_s = 300"),
              HasSubstr("expected one of 250, 500, 1000, 2000 deg/s"));
  EXPECT_THAT(ErrorAfter("[gyro]", "accel_range_g = 2", "accel_range_g = 3"),
              HasSubstr("expected one of 2, 4, 8, 16 g"));
}

TEST_F(StandFile, RefusesAPlaceThatIsNotOnEarth) {
  EXPECT_THAT(ErrorAfter("[reference]", "# scale_uncertainty = 0.0001", "scale_uncertainty = 100"),
              HasSubstr("reference.scale_uncertainty"));
  EXPECT_THAT(ErrorAfter("[site]", "# latitude_deg = 55.75", "latitude_deg = 90.1"),
              HasSubstr("expected a number in -90 .. 90 deg"));
  EXPECT_THAT(ErrorAfter("[site]", "heading_deg = 0", "heading_deg = nan"),
              HasSubstr("site.heading_deg = nan"));
}

TEST_F(StandFile, SaysHowTheAxesLean) {
  std::string text = Shipped();
  text = Replace(text, "[geometry]", "outer_middle_deg = 0", "outer_middle_deg = -4");
  text = Replace(text, "[geometry]", "middle_inner_deg = 0", "middle_inner_deg = 5");
  const StandConfig stand = Load(text);
  EXPECT_EQ(stand.geometry.outer_middle_deg, -4);
  EXPECT_EQ(stand.geometry.middle_inner_deg, 5);
  EXPECT_EQ(stand.geometry.mount_deg[2], 0);
}

TEST_F(StandFile, RefusesAMountingThatContradictsItself) {
  EXPECT_THAT(ErrorAfter("[geometry]", "mount_x_deg = 0", "mount_x_deg = 181"),
              HasSubstr("geometry.mount_x_deg = 181: expected a number in -180 .. 180 deg"));
  EXPECT_THAT(ErrorAfter("[geometry]", "mount_y_deg = 0", "mount_y_deg = nan"),
              HasSubstr("geometry.mount_y_deg = nan"));
  EXPECT_THAT(ErrorAfter("[geometry]", "outer_middle_deg = 0", "outer_middle_deg = 11"),
              HasSubstr("expected a number in -10 .. 10 deg"));
  EXPECT_THAT(ErrorAfter("[geometry]", "mount_x_deg", "mount_deg"),
              HasSubstr("unknown key geometry.mount_deg"));
}

TEST_F(StandFile, RefusesTheLeanOfAnAxisThatIsNotThere) {
  const std::string one_axis = ReadText(ConfigFolder() / "one-axis.toml");
  const auto error = [&](const std::string& key) {
    return ErrorOf([&] { Load(one_axis + "\n[geometry]\n" + key + " = 0.5\n"); });
  };
  EXPECT_THAT(error("outer_middle_deg"),
              AllOf(HasSubstr("geometry.outer_middle_deg = 0.5: expected 0 on a stand without "
                              "[axis.outer]"),
                    HasSubstr("mount_x_deg")));
  EXPECT_THAT(error("middle_inner_deg"), HasSubstr("on a stand without [axis.middle]"));
  EXPECT_EQ(error("mount_x_deg"), "");
}

TEST_F(StandFile, RefusesRelaysThatContradictThemselvesOrTheUnit) {
  const auto error = [&](const std::string& keys) {
    return ErrorOf([&] {
      Load(Shipped() + "\n[relays]\nbus = \"a\"\nmap = \"devices/relay-unit.toml\"\n" + keys);
    });
  };
  EXPECT_EQ(error("unit = 31\nheater = 7\nheater_max_degC = 45\n"), "");
  EXPECT_THAT(error("unit = 31\nfan = 0\nheater = 0\n"), HasSubstr("fan is on this channel"));
  EXPECT_THAT(error("unit = 31\nfan = 8\n"), HasSubstr("relays.fan = 8: expected 0 .. 7"));
  EXPECT_THAT(error("unit = 31\n"), HasSubstr("expected fan, heater or both"));
  EXPECT_THAT(error("unit = 31\nfan = 1\nheater_max_degC = 45\n"),
              HasSubstr("expected none without a heater"));
  EXPECT_THAT(error("unit = 1\nfan = 1\n"), HasSubstr("is unit 1 on bus \"a\" already"));
}

TEST_F(StandFile, RefusesAChannelPrefixThatLcmCannotCarry) {
  for (const std::string& prefix : {std::string("bench"), std::string("A-B"), std::string("1A"),
                                    std::string("_A"), std::string(51, 'A')}) {
    EXPECT_THAT(ErrorAfter("[lcm]", "\"GYROBENCH\"", "\"" + prefix + "\""),
                HasSubstr("lcm.channel_prefix"))
        << prefix;
  }
  EXPECT_NO_THROW(
      Load(Replace(Shipped(), "[lcm]", "\"GYROBENCH\"", "\"" + std::string(50, 'A') + "\"")));
}

TEST_F(StandFile, RefusesAProviderThatAbortsTheProcess) {
  EXPECT_THAT(ErrorAfter("[lcm]", "udpm://239.255.76.67:7667?ttl=0", "tcpq://localhost"),
              HasSubstr("expected udpm://"));
  for (const char* url :
       {"udpm://239.255.76.67:99999", "udpm://239.255.76.67:0?ttl=0", "udpm://239.255.76.67",
        "udpm://192.168.1.7:7667", "udpm://here:7667", "udpm://239.255.76.67:76x7"}) {
    EXPECT_THAT(ErrorAfter("[lcm]", "udpm://239.255.76.67:7667?ttl=0", url),
                HasSubstr("a multicast address (224.0.0.0 to 239.255.255.255) and a port"))
        << url;
  }
}

TEST_F(StandFile, RefusesASocketPathThatUnixCannotBind) {
  EXPECT_THAT(ErrorAfter("", "/run/gyrobench/control.sock", "/" + std::string(107, 's')),
              HasSubstr("has 108 bytes; expected at most 107"));
  EXPECT_NO_THROW(
      Load(Replace(Shipped(), "", "/run/gyrobench/control.sock", "/" + std::string(106, 's'))));
}

TEST_F(StandFile, RefusesSocketPermissionsWrittenInDecimal) {
  EXPECT_THAT(ErrorAfter("", "control_socket_mode = 0o660", "control_socket_mode = 660"),
              HasSubstr("expected permissions in octal"));
}

TEST_F(StandFile, RefusesADeviceMapOrScenarioThatIsNotThere) {
  EXPECT_THAT(ErrorAfter("[gyro]", "gyro-unit.toml", "gyro-unit2.toml"),
              AllOf(HasSubstr("gyro.map = "), HasSubstr("no such file")));
  const auto error =
      ErrorOf([&] { Load("include = \"virtual.toml\"\n[virtual]\nscenario = \"none.toml\"\n"); });
  EXPECT_THAT(error,
              AllOf(HasSubstr("edited.toml:3: virtual.scenario"), HasSubstr("no such file")));
}

TEST_F(StandFile, NamesTheMapFileWhenTheErrorIsThere) {
  const auto map = ReadText(ConfigFolder() / "devices/leadshine-rs.toml");
  folder_.Write("devices/leadshine-rs.toml", Replace(map, "", "fault_bit = 0", "fault_bit = 16"));
  EXPECT_THAT(
      ErrorOf([&] { Load(Shipped()); }),
      HasSubstr(fmt::format("devices/leadshine-rs.toml:{}: fault_bit = 16: expected a whole "
                            "number in 0 .. 15",
                            LineOf(map, "", "fault_bit"))));
}

TEST_F(StandFile, RefusesTheKeysOfAnotherTransport) {
  EXPECT_THAT(ErrorAfter("[bus.a]", "stop_bits = 1", "port = 502"),
              HasSubstr("unknown key bus.a.port"));
}

TEST_F(StandFile, RefusesAnIdleRateAboveTheRate) {
  EXPECT_THAT(ErrorAfter("[axis.middle.encoder]", "idle_rate_hz = 5", "idle_rate_hz = 51"),
              HasSubstr("expected at most rate_hz = 50 Hz"));
}

TEST_F(StandFile, RefusesASignThatIsNone) {
  EXPECT_THAT(ErrorAfter("[axis.middle.encoder]", "sign = 1", "sign = 0"),
              HasSubstr("expected 1 or -1"));
}

TEST_F(StandFile, RefusesOneLineForTwoBuses) {
  EXPECT_THAT(ErrorAfter("[bus.b]", "/dev/ttyUSB1", "/dev/ttyUSB0"),
              HasSubstr("it is that of bus a too"));
}

TEST_F(StandFile, NeedsABusAndAnAxis) {
  EXPECT_THAT(
      ErrorOf([&] { Load("name = \"n\"\nprocedures = [\"p\"]\ncontrol_socket = \"s\"\n"); }),
      HasSubstr("bus is missing"));
  EXPECT_THAT(ErrorOf([&] {
                Load("name = \"n\"\nprocedures = [\"p\"]\ncontrol_socket = \"s\"\n[bus]\n[axis]\n");
              }),
              HasSubstr("expected at least one table [bus.NAME]"));
}

TEST_F(StandFile, GivesTheAxesFromTheFrameInwards) {
  const StandConfig stand = Load(Shipped());
  ASSERT_EQ(stand.axes.size(), 3u);
  EXPECT_EQ(stand.axes[0].name, "outer");
  EXPECT_EQ(stand.axes[1].name, "middle");
  EXPECT_EQ(stand.axes[2].name, "inner");
}

}  // namespace
}  // namespace gyrobench::config
