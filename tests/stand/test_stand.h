// A stand for tests: three axes and a gyro unit on two buses, and what the tests ask of it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "config/scenario.h"
#include "config/stand_config.h"
#include "stand/bench_physics.h"

namespace gyrobench::stand {

inline constexpr Utime kStart = 1'700'000'000'000'000;
inline Utime At(double t_s) { return kStart + FromSeconds(t_s); }

inline config::GyroUnitMap TestGyroMap() {
  config::GyroUnitMap map;
  map.model = "test unit";
  map.gyro_range_deg_s = {250, 500, 1000, 2000};
  map.gyro_lsb_per_deg_s = {131, 65.5, 32.8, 16.4};
  map.accel_range_g = {2, 4, 8, 16};
  map.accel_lsb_per_g = {16384, 8192, 4096, 2048};
  map.filter_bandwidth_hz = {256, 188, 98, 42, 20, 10, 5};
  map.filter_delay_s = {0.00098, 0.0019, 0.0028, 0.0048, 0.0083, 0.0134, 0.0186};
  return map;
}

inline config::DriveMap TestDriveMap() {
  config::DriveMap map;
  map.model = "test drive";
  map.pulses_per_turn_address = 0x0001;
  map.enable_address = 0x000F;
  map.status_address = 0x1003;
  map.position_address = 0x602A;
  map.alarm_address = 0x2203;
  map.control_address = 0x1801;
  map.trigger_address = 0x6002;
  map.path_address = 0x6200;
  return map;
}

inline config::AxisConfig TestAxis(const char* name, int number) {
  config::AxisConfig axis;
  axis.name = name;
  axis.drive = {.bus = "a", .unit = number, .map = TestDriveMap()};
  axis.encoder.bus = "a";
  axis.encoder.unit = 10 + number;
  axis.encoder.map.model = "test encoder";
  axis.encoder.map.words = 2;
  axis.encoder.map.counts_per_turn = 1 << 20;
  axis.encoder.map.range_counts = std::uint64_t{1} << 32U;
  return axis;
}

inline config::StandConfig TestStand() {
  config::StandConfig stand;
  stand.name = "test stand";
  stand.buses.resize(2);
  stand.buses[0].name = "a";
  stand.buses[1].name = "b";
  stand.axes = {TestAxis("outer", 1), TestAxis("middle", 2), TestAxis("inner", 3)};
  stand.gyro.bus = "b";
  stand.gyro.map = TestGyroMap();
  stand.site.latitude_deg = 52.0;
  stand.site.heading_deg = 30.0;
  return stand;
}

// Table rate and angle as the drive takes them: whole rpm, whole pulses.
inline MoveCommand TestMove(double rpm, double ramp_ms = 100.0) {
  return {.rpm = rpm, .ramp_up_ms = ramp_ms, .ramp_down_ms = ramp_ms};
}
inline std::int64_t Pulses(double table_deg) {
  return std::llround(table_deg / 360.0 * 40.0 * 10000.0);
}

// A sample of the unit in physical units, nominal sensitivity.
struct Sample {
  std::uint32_t number = 0, tick = 0;
  std::array<double, 3> rate_deg_s = {}, accel_g = {};
  double temperature_degC = 0.0;
};

// All samples that the unit takes between `from_s` and `to_s`, read every `poll_s`.
inline std::vector<Sample> ReadSamples(Physics& physics, double from_s, double to_s,
                                       double poll_s = 0.05) {
  std::vector<Sample> samples;
  std::uint32_t next =
      physics.WithGyro(At(from_s), [](auto& gyro, double) { return gyro.next_number(); });
  const auto take = [&](GyroSampler& gyro, double) {
    for (next = std::max(next, gyro.oldest_number()); next < gyro.next_number(); ++next) {
      const RawSample& raw = gyro.sample(next);
      const auto range = static_cast<std::size_t>(gyro.settings().range);
      Sample sample{
          .number = next, .tick = raw.tick, .temperature_degC = raw.words[3] / 340.0 + 36.53};
      for (std::size_t i = 0; i < 3; ++i) {
        sample.accel_g[i] = raw.words[i] / 16384.0;
        sample.rate_deg_s[i] = raw.words[4 + i] / TestGyroMap().gyro_lsb_per_deg_s[range];
      }
      samples.push_back(sample);
    }
  };
  for (double t = from_s; t < to_s; t += poll_s) {
    physics.WithGyro(At(std::min(t + poll_s, to_s)), take);
  }
  return samples;
}

}  // namespace gyrobench::stand
