#include "tests/fuzz/device_laws.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>

#include "base/error.h"
#include "drivers/factory.h"
#include "drivers/modbus_bus.h"
#include "tests/drivers/fake_line.h"
#include "tests/drivers/gyro_unit_model.h"
#include "tests/drivers/manual_clock.h"
#include "tests/fuzz/laws.h"

namespace gyrobench::testing {
namespace {

constexpr int kGyroUnit = 21, kDriveUnit = 3, kEncoderUnit = 13;
constexpr std::uint16_t kPathAddress = 0x6200;

// Bytes, one after the other, then zeros. From the thread of the test and that of the line.
class Tape {
 public:
  explicit Tape(const std::string& bytes) : bytes_(bytes) {}
  std::uint8_t Next() {
    const std::lock_guard lock(mutex_);
    return at_ < bytes_.size() ? static_cast<std::uint8_t>(bytes_[at_++]) : std::uint8_t{0};
  }
  std::uint16_t Word() {
    const unsigned high = Next();
    return static_cast<std::uint16_t>(high << 8U | Next());
  }
  bool over() const {
    const std::lock_guard lock(mutex_);
    return at_ >= bytes_.size();
  }

 private:
  mutable std::mutex mutex_;
  const std::string bytes_;
  std::size_t at_ = 0;
};

// A device whose replies the tape damages.
class DamagedUnit final : public FakeUnit {
 public:
  DamagedUnit(FakeUnit& whole, Tape& tape) : whole_(whole), tape_(tape) {}

  Words Read(int function, std::uint16_t address, std::uint16_t count) override {
    constexpr std::uint8_t kSound = 128, kManyWords = 250;
    Words words = whole_.Read(function, address, count);
    const std::uint8_t damage = tape_.Next();
    if (damage < kSound || words.empty()) return words;
    if (damage >= kManyWords) throw ModbusException{1 + damage % 6};
    for (int i = 0; i < 1 + damage % 4; ++i) words[tape_.Next() % words.size()] = tape_.Word();
    return words;
  }
  void Write(std::uint16_t address, const Words& values) override { whole_.Write(address, values); }

 private:
  FakeUnit& whole_;
  Tape& tape_;
};

config::AxisConfig InnerAxisOfTape() {
  config::AxisConfig axis;
  axis.name = "inner";
  axis.drive.unit = kDriveUnit;
  axis.drive.map.model = "drive of the tape";
  axis.drive.map.pulses_per_turn_address = 0x0001;
  axis.drive.map.enable_address = 0x000F;
  axis.drive.map.status_address = 0x1003;
  axis.drive.map.position_address = 0x602A;
  axis.drive.map.alarm_address = 0x2203;
  axis.drive.map.control_address = 0x1801;
  axis.drive.map.trigger_address = 0x6002;
  axis.drive.map.path_address = kPathAddress;
  axis.encoder.unit = kEncoderUnit;
  axis.encoder.map = {.model = "encoder of the tape",
                      .words = 2,
                      .counts_per_turn = 131072,
                      .range_counts = std::uint64_t{1} << 29U};
  return axis;
}

config::GyroConfig GyroOfTape() {
  config::GyroConfig gyro;
  gyro.unit = kGyroUnit;
  gyro.map = GyroMapOfThePage();
  gyro.range_deg_s = 500;
  gyro.rate_hz = 200;
  return gyro;
}

void RequireFinite(double value, const char* what) {
  if (!std::isfinite(value)) throw BrokenLaw(what);
}

class Bench {
 public:
  explicit Bench(const std::string& bytes) : tape_(bytes) {
    drive_.SetHolding(0x0001, {10000});
    drive_.SetHolding(0x000F, {1});
    drive_.SetHolding(0x1003, {0x0032});
    drive_.SetHolding(0x602A, {0, 0});
    drive_.SetHolding(0x2203, {0});
    encoder_.SetHolding(0, {0, 1000});
    clock_.real_timeout_us = 20'000;
    line_.Connect(kGyroUnit, damaged_gyro_);
    line_.Connect(kDriveUnit, damaged_drive_);
    line_.Connect(kEncoderUnit, damaged_encoder_);
  }

  int Play() {
    constexpr int kMostCalls = 60;
    int succeeded = 0;
    for (int i = 0; i < kMostCalls && !tape_.over(); ++i) {
      try {
        Call(tape_.Next() % 10);
        ++succeeded;
      } catch (const Error& error) {
        if (std::string(error.what()).empty()) throw BrokenLaw("an error without words");
      }
      clock_.Advance(20'000);
    }
    return succeeded;
  }

 private:
  void Call(int which) {
    switch (which) {
      case 0:
        RequireFinite(gyro_->Open().sample_rate_hz, "sample rate");
        newest_ = -1;
        break;
      case 1:
      case 2:
      case 3:
        gyro_model_.Take(1 + tape_.Next() % 70);
        ReadGyro();
        break;
      case 4:
        RequireFinite(axis_->Open().commanded_deg, "count of the drive");
        break;
      case 5:
        RequireFinite(axis_->Read().commanded_deg, "count of the drive");
        break;
      case 6:
        RequireFinite(axis_->MoveBy(tape_.Next() - 128.0, 1 + tape_.Next() % 60, 100), "rate");
        break;
      case 7:
        axis_->Stop();
        axis_->IsMoving();
        break;
      case 8:
        RequireFinite(sensor_->Open().angle_deg, "angle");
        break;
      default:
        RequireFinite(sensor_->Read().angle_deg, "angle");
    }
  }

  void ReadGyro() {
    gyro_->Read(block_);
    if (block_.missed < 0) throw BrokenLaw("samples missed: a negative number");
    if (block_.boot_count != boot_count_) newest_ = -1;
    boot_count_ = block_.boot_count;
    for (const drivers::GyroRawSample& sample : block_.samples) {
      if (sample.counter <= newest_) throw BrokenLaw("samples out of order");
      newest_ = sample.counter;
      RequireFinite(sample.temperature_degC, "temperature");
    }
  }

  Tape tape_;
  GyroUnitModel gyro_model_;
  RegisterUnit drive_, encoder_;
  DamagedUnit damaged_gyro_{gyro_model_, tape_}, damaged_drive_{drive_, tape_},
      damaged_encoder_{encoder_, tape_};
  FakeLine line_{config::BusConfig::Transport::kRtu};
  ManualClock clock_;
  std::unique_ptr<Clock::Participant> participant_ = clock_.Join("bus", Clock::Role::kResident);
  drivers::ModbusBus bus_{line_.Config(), clock_, *participant_};
  std::unique_ptr<drivers::Gyro> gyro_ = drivers::MakeGyro(GyroOfTape(), bus_);
  std::unique_ptr<drivers::Axis> axis_ = drivers::MakeAxis(InnerAxisOfTape(), bus_);
  std::unique_ptr<drivers::AngleSensor> sensor_ = drivers::MakeAngleSensor(InnerAxisOfTape(), bus_);
  drivers::GyroBlock block_;
  std::int64_t newest_ = -1;
  int boot_count_ = -1;
};

}  // namespace

int TalkToDevices(const std::string& tape) { return Bench(tape).Play(); }

}  // namespace gyrobench::testing
