// The driver of the gyro unit and the firmware's image: one Modbus, one clock, one set of samples.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "config/stand_config.h"
#include "drivers/factory.h"
#include "drivers/modbus_bus.h"
#include "stand/bench_physics.h"
#include "stand/virtual_stand.h"
#include "tests/firmware/emulation/emulated_gyro_device.h"

namespace gyrobench::firmware {
namespace {

constexpr Utime kStart = 1'700'000'000'000'000;

config::Scenario Quiet(double tick_rel) {
  config::Scenario scenario = config::IdealScenario();
  scenario.bus.turnaround_s = 0.004;
  scenario.unit.tick_rel = tick_rel;
  return scenario;
}

// A virtual stand whose gyro unit is the image.
struct Bench {
  explicit Bench(const config::Scenario& scenario)
      : config(config::LoadStandConfig(GYROBENCH_SOURCE_DIR "/config/virtual.toml")),
        stand(config, scenario, 1, *clock, [this](stand::Physics& physics, Utime start) {
          return std::make_unique<EmulatedGyroDevice>(GYROBENCH_FIRMWARE_IMAGE, config.gyro.map,
                                                      physics, start);
        }) {
    for (const config::BusConfig& bus : config.buses) {
      const config::BusConfig served = stand.Serve(bus);
      if (bus.name == config.gyro.bus)
        gyro_line = std::make_unique<drivers::ModbusBus>(served, *clock, *me);
      if (bus.name == config.axes.back().drive.bus)
        axis_line = std::make_unique<drivers::ModbusBus>(served, *clock, *me);
    }
    me->WaitUntil(clock->Now() + FromSeconds(0.5));
    gyro = drivers::MakeGyro(config.gyro, *gyro_line);
    axis = drivers::MakeAxis(config.axes.back(), *axis_line);
  }

  config::StandConfig config;
  std::unique_ptr<VirtualClock> clock = MakeVirtualClock(kStart);
  std::unique_ptr<Clock::Participant> me = clock->Join("test");
  stand::VirtualStand stand;
  std::unique_ptr<drivers::ModbusBus> gyro_line, axis_line;
  std::unique_ptr<drivers::Gyro> gyro;
  std::unique_ptr<drivers::Axis> axis;
};

TEST(DriverAndFirmware, KnowEachOther) {
  Bench bench(Quiet(0.0));
  const drivers::GyroIdentity identity = bench.gyro->Open();
  EXPECT_EQ(identity.protocol_version, 1);
  EXPECT_EQ(identity.boot_count, 1);
  EXPECT_EQ(identity.sample_rate_hz, bench.config.gyro.rate_hz);
}

// The processor's resonator is a quarter of a percent off: the turn that the gyro's samples make up
// over the host's time is what the table turned all the same.
TEST(DriverAndFirmware, AResonatorThatIsOffIsInTheTicksAndNotInTheTurn) {
  for (const double tick_rel : {0.0, 0.0025}) {
    SCOPED_TRACE(tick_rel);
    Bench bench(Quiet(tick_rel));
    bench.gyro->Open();
    bench.axis->Open();
    drivers::GyroBlock block;
    std::int64_t last = -1, missed = 0;
    double turned_lsb_s = 0.0;
    Utime before = 0;
    drivers::GyroRawSample first, newest;
    for (int i = 0; i < 100; ++i) {
      bench.me->WaitUntil(bench.clock->Now() + FromSeconds(0.05));
      if (i == 20) bench.axis->MoveBy(90.0, 40.0, 100.0);
      bench.gyro->Read(block);
      missed += block.missed;
      for (const drivers::GyroRawSample& sample : block.samples) {
        if (last >= 0) {
          ASSERT_EQ(sample.counter, last + 1);
          turned_lsb_s += sample.gyro_lsb[2] * ToSeconds(sample.utime - before);
        } else {
          first = sample;
        }
        last = sample.counter;
        before = sample.utime;
        newest = sample;
      }
    }
    EXPECT_EQ(missed, 0);
    EXPECT_GT(last, 900);
    const double range_lsb_per_deg_s =
        bench.config.gyro.map.gyro_lsb_per_deg_s[bench.config.gyro.range_deg_s == 250.0 ? 0 : 1];
    EXPECT_NEAR(std::fabs(turned_lsb_s) / range_lsb_per_deg_s, 90.0, 0.02);
    const double ticks = static_cast<double>(newest.tick - first.tick);
    EXPECT_NEAR(ticks / (250e3 * ToSeconds(newest.utime - first.utime)) - 1.0, tick_rel, 2e-5);
  }
}

}  // namespace
}  // namespace gyrobench::firmware
