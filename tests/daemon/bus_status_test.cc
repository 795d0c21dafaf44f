// What is told of the lines: shares of the time that has passed, and nothing where none has.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/control_api.h"

namespace gyrobench::daemon {
namespace {

using nlohmann::json;

constexpr Utime kStart = 1'700'000'000'000'000;

drivers::LineFigures ALine(Utime span_us) {
  drivers::UnitFigures unit;
  unit.device = "gyro";
  unit.unit = 21;
  unit.transactions = 4;
  unit.given_up = unit.silent = 1;
  unit.busy_us = 250'000;
  drivers::LineFigures line;
  line.bus = "b";
  line.utime_begin = line.utime_recent = kStart;
  line.utime_now = kStart + span_us;
  line.all = line.recent = {unit, unit};
  return line;
}

config::StandConfig StandWith(config::BusConfig::Transport transport) {
  config::StandConfig stand;
  config::BusConfig bus;
  bus.name = "b";
  bus.transport = transport;
  stand.buses = {bus};
  stand.gyro.bus = "b";
  return stand;
}

TEST(BusStatus, TheLoadOfALineIsThatOfItsUnits) {
  const auto stand = StandWith(config::BusConfig::Transport::kRtu);
  const json bus = BusStatus(stand, {ALine(1'000'000)})["buses"][0];
  EXPECT_EQ(bus["name"], "b");
  EXPECT_EQ(bus["all"]["seconds"], 1.0);
  EXPECT_EQ(bus["all"]["load"], 0.5);
  EXPECT_EQ(bus["all"]["units"][0]["load"], 0.25);
  EXPECT_EQ(bus["all"]["units"][0]["given_up"], 1);
  EXPECT_TRUE(bus["all"]["units"][0]["latency_median_s"].is_null());
  EXPECT_GT(bus["expected_load"], 0.0);
}

TEST(BusStatus, BeforeAnyTimeHasPassedThereIsNoLoad) {
  const auto stand = StandWith(config::BusConfig::Transport::kRtu);
  const json bus = BusStatus(stand, {ALine(0)})["buses"][0];
  EXPECT_TRUE(bus["all"]["load"].is_null());
  EXPECT_TRUE(bus["recent"]["units"][0]["load"].is_null());
}

TEST(BusStatus, NothingIsExpectedOfALineWhoseWireIsNotOurs) {
  const auto stand = StandWith(config::BusConfig::Transport::kTcp);
  EXPECT_TRUE(BusStatus(stand, {ALine(1'000'000)})["buses"][0]["expected_load"].is_null());
}

}  // namespace
}  // namespace gyrobench::daemon
