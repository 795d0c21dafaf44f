// The real drivers on the virtual stand: both sides of the Modbus agree on registers, times and
// signs.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "config/stand_config.h"
#include "drivers/factory.h"
#include "drivers/modbus_bus.h"
#include "stand/bench_physics.h"
#include "stand/virtual_stand.h"
#include "tests/stand/test_stand.h"

namespace gyrobench::stand {
namespace {

config::StandConfig ShippedStand() {
  return config::LoadStandConfig(std::string(GYROBENCH_SOURCE_DIR) + "/config/virtual.toml");
}

struct OneLine {
  explicit OneLine(const config::Scenario& scenario, const std::string& bus_name,
                   config::StandConfig its_config = ShippedStand())
      : config(std::move(its_config)), stand(config, scenario, *clock) {
    for (const config::BusConfig& bus : config.buses) {
      if (bus.name == bus_name)
        line = std::make_unique<drivers::ModbusBus>(stand.Serve(bus), *clock, *me);
    }
  }
  config::StandConfig config;
  std::unique_ptr<VirtualClock> clock = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me = clock->Join("test");
  VirtualStand stand;
  std::unique_ptr<drivers::ModbusBus> line;
};

TEST(DriversOnStand, TheGyroIsReadWithoutLossAndItsTicksAreTimedToMicroseconds) {
  config::Scenario scenario = config::IdealScenario();
  scenario.unit.tick_rel = 0.002;
  scenario.gyro.sample_clock_rel = -0.004;
  OneLine bench(scenario, "b");
  const auto gyro = drivers::MakeGyro(bench.config.gyro, *bench.line);
  gyro->Open();
  drivers::GyroBlock block;
  std::int64_t last = -1;
  double worst_s = 0.0;
  for (int i = 0; i < 1500; ++i) {
    bench.me->WaitUntil(bench.clock->Now() + 50'000);
    gyro->Read(block);
    EXPECT_EQ(block.missed, 0);
    for (const auto& sample : block.samples) {
      if (last >= 0) {
        ASSERT_EQ(sample.counter, last + 1);
      }
      last = sample.counter;
      if (i < 1000) continue;
      // Sample n is taken (n + 1) periods after the settings were written; here only the spacing
      // counts.
      const double spacing_s =
          ToSeconds(sample.utime - kStart) / static_cast<double>(sample.counter + 1);
      worst_s = std::max(worst_s, std::abs(spacing_s * 200 * (1 - 0.004) - 1) *
                                      static_cast<double>(sample.counter + 1) / 200);
    }
  }
  EXPECT_GT(last, 14000);
  EXPECT_LT(worst_s, 0.02);
}

TEST(DriversOnStand, AMoveOfTheAxisIsWhatTheAngleSensorReads) {
  OneLine bench(config::IdealScenario(), "a");
  for (const config::AxisConfig& config : bench.config.axes) {
    const auto axis = drivers::MakeAxis(config, *bench.line);
    const auto sensor = drivers::MakeAngleSensor(config, *bench.line);
    axis->Open();
    sensor->Open();
    for (const double angle_deg : {45.0, -99.0, 18.0}) {
      const double before = sensor->Read().angle_deg;
      const double rate = axis->MoveBy(angle_deg, 20.0, 80.0);
      EXPECT_NEAR(rate, 20.0, 0.15);
      bench.me->WaitUntil(bench.clock->Now() + FromSeconds(std::abs(angle_deg) / rate + 1.0));
      EXPECT_FALSE(axis->Read().moving);
      EXPECT_NEAR(sensor->Read().angle_deg - before, angle_deg, 0.01);
    }
  }
}

// The time that the driver gives a reading is the one at which the stand took it.
TEST(DriversOnStand, AReadingOfAMovingTableIsTimedRight) {
  OneLine bench(config::IdealScenario(), "a");
  const config::AxisConfig& config = bench.config.axes.back();
  const auto axis = drivers::MakeAxis(config, *bench.line);
  const auto sensor = drivers::MakeAngleSensor(config, *bench.line);
  axis->Open();
  sensor->Open();
  axis->MoveBy(180.0, 45.0, 100.0);
  bench.me->WaitUntil(bench.clock->Now() + FromSeconds(2.0));
  const auto first = sensor->Read();
  bench.me->WaitUntil(bench.clock->Now() + FromSeconds(1.2345));
  const auto second = sensor->Read();
  const auto truth = [&](Utime at) { return bench.stand.physics().Truth(2, at).table_deg; };
  const double count_deg = 360.0 / config.encoder.map.counts_per_turn;
  EXPECT_NEAR(second.angle_deg, truth(second.utime), count_deg + 45.0 * 5e-6);
  EXPECT_NEAR(second.angle_deg - first.angle_deg, 45.0 * ToSeconds(second.utime - first.utime),
              2 * count_deg + 45.0 * 1e-5);
}

// Fan and heater on the gyro's own line.
class OutputsOnStand : public testing::Test {
 protected:
  static config::StandConfig WithRelays() {
    auto config =
        config::LoadStandConfig(std::string(GYROBENCH_SOURCE_DIR) + "/config/relays.toml");
    config.relays->bus = "b";
    return config;
  }
  static config::Scenario Warm() {
    config::Scenario scenario = config::IdealScenario();
    scenario.thermal.time_constant_s = scenario.room.fan_time_constant_s = 5;
    scenario.room.fan_drop_degC = 10;
    scenario.room.heater_rise_degC = 20;
    return scenario;
  }
  double TemperatureAfter(double duration_s) {
    drivers::GyroBlock block;
    for (const double wait_s : {duration_s, 0.05}) {  // the ring first, that ran over meanwhile
      bench_.me->WaitUntil(bench_.clock->Now() + FromSeconds(wait_s));
      gyro_->Read(block);
    }
    return block.samples.back().temperature_degC;
  }

  OneLine bench_{Warm(), "b", WithRelays()};
  std::unique_ptr<drivers::Gyro> gyro_ = drivers::MakeGyro(bench_.config.gyro, *bench_.line);
  std::unique_ptr<drivers::Relays> relays_ =
      drivers::MakeRelays(*bench_.config.relays, *bench_.line);
};

TEST_F(OutputsOnStand, AHeaterWarmsAFanCoolsAndOpeningSwitchesBothOff) {
  gyro_->Open();
  relays_->Open();
  const double rest_degC = TemperatureAfter(60);
  relays_->Switch("heater", true);
  EXPECT_NEAR(TemperatureAfter(60) - rest_degC, 20, 0.1);
  relays_->Switch("heater", false);
  relays_->Switch("fan", true);
  EXPECT_NEAR(TemperatureAfter(60) - rest_degC, -10, 0.1);
  EXPECT_EQ(relays_->Read(), (std::map<std::string, bool>{{"fan", true}, {"heater", false}}));
  relays_->Open();
  EXPECT_NEAR(TemperatureAfter(60) - rest_degC, 0, 0.1);
}

// Left on by a daemon that was killed, or by somebody else.
TEST_F(OutputsOnStand, OpeningSwitchesOffWhatItFindsOn) {
  const drivers::ModbusUnit unit{"somebody else", bench_.config.relays->unit};
  for (const std::uint16_t coil : {std::uint16_t{0}, std::uint16_t{1}}) {
    bench_.line->WriteCoil(unit, coil, true, "a coil");
  }
  EXPECT_EQ(relays_->Read(), (std::map<std::string, bool>{{"fan", true}, {"heater", true}}));
  relays_->Open();
  EXPECT_EQ(relays_->Read(), (std::map<std::string, bool>{{"fan", false}, {"heater", false}}));
  EXPECT_THROW(bench_.line->WriteCoil(unit, 8, true, "channel 8 of 8"), DeviceError);
  EXPECT_THROW(relays_->Switch("pump", true), LimitError);
}

// Two lines, each with its thread, on one virtual clock.
std::vector<double> RunTwoLines() {
  const config::StandConfig config = ShippedStand();
  const auto clock = MakeVirtualClock(kStart);
  VirtualStand stand(config, config::Scenario{}, 5, *clock);
  auto main = clock->Join("main");
  auto axis_thread = clock->Join("a");
  auto gyro_thread = clock->Join("b");
  std::vector<double> readings, rates;
  std::thread a([&] {
    const std::unique_ptr<Clock::Participant> me = std::move(axis_thread);
    drivers::ModbusBus line(stand.Serve(config.buses[0]), *clock, *me);
    const auto axis = drivers::MakeAxis(config.axes[2], line);
    const auto sensor = drivers::MakeAngleSensor(config.axes[2], line);
    axis->Open();
    sensor->Open();
    axis->MoveBy(36.0, 20.0, 80.0);
    for (int i = 0; i < 100; ++i) {
      me->WaitUntil(kStart + 100'000 + 20'000 * i);
      readings.push_back(sensor->Read().angle_deg);
    }
  });
  std::thread b([&] {
    const std::unique_ptr<Clock::Participant> me = std::move(gyro_thread);
    drivers::ModbusBus line(stand.Serve(config.buses[1]), *clock, *me);
    const auto gyro = drivers::MakeGyro(config.gyro, line);
    gyro->Open();
    drivers::GyroBlock block;
    for (int i = 0; i < 40; ++i) {
      me->WaitUntil(kStart + 130'000 + 50'000 * i);
      gyro->Read(block);
      for (const auto& sample : block.samples) rates.push_back(sample.gyro_lsb[2]);
    }
  });
  main.reset();
  a.join();
  b.join();
  readings.insert(readings.end(), rates.begin(), rates.end());
  return readings;
}

TEST(DriversOnStand, TwoLinesInTwoThreadsGiveTheSameNumbersInEveryRun) {
  const std::vector<double> first = RunTwoLines();
  EXPECT_GT(first.size(), 450U);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(RunTwoLines(), first);
}

}  // namespace
}  // namespace gyrobench::stand
