// A gyro unit on a line of its own, and its driver.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>

#include "base/error.h"
#include "drivers/factory.h"
#include "drivers/gyro_unit.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/gyro_unit_model.h"
#include "tests/drivers/manual_clock.h"

namespace gyrobench::drivers {

class GyroUnitTest : public testing::Test {
 protected:
  static constexpr double kTicksPerSecond = 250000.0;

  GyroUnitTest() {
    line_.Connect(21, model_);
    gyro_ = MakeGyro(Config(), bus_);
  }
  static config::GyroConfig Config() {
    config::GyroConfig config;
    config.map = GyroMapOfThePage();
    config.range_deg_s = 500;
    config.filter = 2;
    config.rate_hz = 200;
    config.accel_range_g = 16;
    return config;
  }
  // Time passes for the host and, with samples every 5 ms of its own clock, for the unit.
  void Pass(int samples) {
    model_.Take(samples);
    clock_.Advance(Utime{5000} * samples);
  }
  std::string OpenFailure(const config::GyroConfig& config) {
    try {
      MakeGyro(config, bus_)->Open();
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }
  // Reads and checks that each sample is the one of its number.
  void ReadInto(GyroBlock& block) {
    gyro_->Read(block);
    for (const GyroRawSample& sample : block.samples) {
      const auto raw = GyroUnitModel::Raw(static_cast<std::uint32_t>(sample.counter));
      ASSERT_THAT(sample.accel_lsb, testing::ElementsAre(raw[0], raw[1], raw[2]));
      ASSERT_NEAR(sample.temperature_degC, raw[3] / 340.0 + 36.53, 1e-12);
      ASSERT_THAT(sample.gyro_lsb, testing::ElementsAre(raw[4], raw[5], raw[6]));
    }
  }

  GyroUnitModel model_;
  FakeLine line_{Transport::kRtu};
  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("bus", Clock::Role::kResident);
  ModbusBus bus_{line_.Config(), clock_, *participant_};
  std::unique_ptr<Gyro> gyro_;
};

}  // namespace gyrobench::drivers
